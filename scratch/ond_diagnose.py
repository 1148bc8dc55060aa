"""Diagnose drawn cases: python ond_diagnose.py SEED ENGINE [NAMES...] -> ond-draws/SEED/ENGINE/NAME.json

Engine is a name only: the code is what PYTHONPATH has. Cases that are there already are skipped.
"""
import json, sys, time
from pathlib import Path
from deltactl.proof.prove.one_case import diagnose_blind
from deltactl.proof.prove.score import score

seed, engine, names = sys.argv[1], sys.argv[2], sys.argv[3:]
root = Path(f"ond-draws/{seed}")
out = root / engine
out.mkdir(exist_ok=True)
names = names or sorted(p.stem for p in root.glob("*_*.json"))
for name in names:
    if (out / f"{name}.json").exists():
        continue
    result = json.loads((root / f"{name}.json").read_text())
    begun, cpu = time.monotonic(), time.process_time()
    result["diagnosis"], result["failure"] = diagnose_blind(root / name)
    result["diagnosed_s"], result["cpu_s"] = time.monotonic() - begun, time.process_time() - cpu
    (out / f"{name}.json").write_text(json.dumps(result))
    m = score(result)
    print(name, m.group, m.motion, "OK" if m.exact else "--", m.truth, "->", m.failure or m.said, f"{result['cpu_s']:.1f}s", flush=True)
