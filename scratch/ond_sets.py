"""Selection alone on drawn cases: python ond_sets.py SEED [NAMES...]; the set against the truth, by group."""
import time,sys,json
from collections import Counter
from pathlib import Path
from deltactl.diagnosis.api import with_effects_in, Document, read_flat
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.selection.near_points import chosen
seed=sys.argv[1]; root=Path('ond-draws')/seed
names=sys.argv[2:] or [f'case_{n:04d}' for n in range(30)]
right,total,secs=Counter(),Counter(),[]
for name in names:
    f=root/name
    truth=json.loads(f.with_suffix('.json').read_text())['truth']
    hidden=sorted(f"{a['effect']} {a['where']}" for a in truth['answers'])
    t=time.process_time()
    try:
        m=DeltaModel(with_effects_in(Document.read(f/'robot.yaml')),[read_flat(f/'recording.csv.gz',lambda _:None)])
        plant,evidence,post=chosen(DeltaPlant(Recorded(m)),lambda _:None)
        by={r.key:r for r in plant.regressors}
        said=sorted({f"{by[k].effect} {by[k].component}" for k in post.best.keys} | {f"stale_reading {s.channel}" for s in plant.recorded.stale})
    except Exception as e:
        import traceback; traceback.print_exc()
        said=[type(e).__name__+str(e)[:80]]
    s=time.process_time()-t; secs.append(s)
    ok=said==hidden if truth['group'] not in ('unknown','seen','unseen','beside') else any('unknown' in x for x in said)
    total[truth['group']]+=1; right[truth['group']]+=ok
    print(name,truth['group'],truth['motion'],'OK' if ok else '--',hidden,'->' ,'' if ok and said==hidden else said,f'{s:.1f}s',flush=True)
    if not ok:
        try:
            print('      ', plant.careful, [(round(w,3),sorted(e.keys)) for e,w in zip(post.explanations[:3],post.weights)], 'chi2/m',round(post.best.chi2/len(evidence.noise.rows),3),flush=True)
        except Exception: pass
print({g:f'{right[g]}/{total[g]}' for g in total}, 'median s',sorted(secs)[len(secs)//2])
