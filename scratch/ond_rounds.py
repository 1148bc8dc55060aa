"""python t5.py NAME: rounds of the named search"""
import sys,json,time
from pathlib import Path
from deltactl.diagnosis.api import with_effects_in, Document, read_flat
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.recorded import Recorded
import deltactl.diagnosis.selection.near_points as np_
f=Path('ond-draws')/sys.argv[2]/sys.argv[1] if len(sys.argv)>2 else Path('ond-draws/61200')/sys.argv[1]
truth=json.loads(f.with_suffix('.json').read_text())['truth']
print(truth['group'],truth['motion'],[(a['effect'],a['where'],a.get('parameters')) for a in truth['answers']])
old=np_._as_built
def spy(plant):
    t=time.process_time(); r=old(plant); p,e,post=r
    print('AT',{k:v.at.round(5).tolist() for k,v in plant.at_work.items()},'unknown',[(k,round(u.gain,1),round(u.paid,1)) for k,u in plant.unknown.items()]); print('   ->',p.careful,round(post.best.log_evidence,1),sorted(post.best.keys),'chi2/m',round(post.best.chi2/len(p.own_noise.rows),4),'here',round(e(plant.point).log_evidence,1),'empty',round(e(frozenset()).log_evidence,1),round(time.process_time()-t,1),'s')
    for ex,w in zip(post.explanations[1:3],post.weights[1:]): print('         ',round(w,3),sorted(ex.keys))
    return r
np_._as_built=spy
m=DeltaModel(with_effects_in(Document.read(f/'robot.yaml')),[read_flat(f/'recording.csv.gz',lambda _:None)])
plant,e,post=np_.chosen(DeltaPlant(Recorded(m)),lambda _:None)
print('END',plant.careful,[(round(w,3),sorted(x.keys)) for x,w in zip(post.explanations[:4],post.weights)])
