"""Sizes whose interval misses the truth: python ond_missed.py SEED ENGINE"""
import json,sys
from pathlib import Path
import numpy as np
root=Path('ond-draws')/sys.argv[1]/sys.argv[2]
for p in sorted(root.glob('*.json')):
    r=json.loads(p.read_text()); d=r['diagnosis']
    if not d: continue
    for a in r['truth']['answers']:
        for f in d['findings']:
            if (f['effect'],f['component'])!=(a['effect'],a['where']): continue
            for n,v in a.get('parameters',{}).items():
                if n not in f['parameters'] or (n=='time' and 'when' in a): continue
                s=f['parameters'][n]
                val=np.atleast_1d(np.array(s['value'],float)); ci=np.array(s['ci95'],float).reshape(-1,2)
                for x,y,(lo,hi) in zip(np.atleast_1d(v),val,ci):
                    if not lo<=x<=hi: print(p.stem,r['truth']['group'],f['effect'],n,'true',round(float(x),6),'said',round(float(y),6),'ci',lo,hi, 'sigmas',round((x-y)/((hi-lo)/3.92),1))
