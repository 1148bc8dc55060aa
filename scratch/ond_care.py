"""Log evidence of the best set by care of building: python ond_care.py SEED NAMES..."""
import sys,json
from pathlib import Path
import deltactl.diagnosis.selection.near_points as np_
from deltactl.diagnosis.api import with_effects_in, Document, read_flat
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.selection.model_posterior import HillClimb
for name in sys.argv[2:]:
    f=Path('ond-draws')/sys.argv[1]/name
    truth=json.loads(f.with_suffix('.json').read_text())['truth']
    m=DeltaModel(with_effects_in(Document.read(f/'robot.yaml')),[read_flat(f/'recording.csv.gz',lambda _:None)])
    plant,e,post=np_.chosen(DeltaPlant(Recorded(m)),lambda _:None)
    print(name,truth['group'],sorted(post.best.keys),plant.careful)
    for odds,p in plant.built():
        h=HillClimb(Laplace(p,plant.own_noise)).run()
        print('    ',round(p.careful,3),round(h.best.log_evidence,1),sorted(h.best.keys),flush=True)
