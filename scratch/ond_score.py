"""Score two engines by group: python ond_score.py SEED ENGINE [ENGINE...]; only cases that all have."""
import json, sys
from collections import defaultdict
from pathlib import Path
import numpy as np
from deltactl.proof.prove.score import score

seed, engines = sys.argv[1], sys.argv[2:]
root = Path(f"ond-draws/{seed}")
names = sorted(set.intersection(*({p.stem for p in (root / e).glob("*.json")} for e in engines)))
table = defaultdict(dict)
for e in engines:
    groups = defaultdict(list)
    for n in names:
        r = json.loads((root / e / f"{n}.json").read_text())
        groups[score(r).group].append((n, score(r), r["cpu_s"]))
    for g, rows in groups.items():
        right = sum((m.exact if g not in ("unknown", "seen", "unseen", "beside") else m.flagged) for _, m, _ in rows)
        table[g][e] = (right, len(rows), np.median([c for *_, c in rows]), sum(sum(m.covered) for _, m, _ in rows), sum(len(m.covered) for _, m, _ in rows))
    everything = [r for rows in groups.values() for r in rows]
    table["all exact"][e] = (sum(m.exact for _, m, _ in everything), len(everything), np.median([c for *_, c in everything]), sum(sum(m.covered) for _, m, _ in everything), sum(len(m.covered) for _, m, _ in everything))
for g, row in table.items():
    print(f"{g:10s}", *(f"{e}: {a:2d}/{n:2d} {s:5.1f}s cov {c}/{k}" for e, (a, n, s, c, k) in row.items()), sep="   ")
for n in names:
    ms = [score(json.loads((root / e / f"{n}.json").read_text())) for e in engines]
    if any(not m.exact for m in ms):
        print(n, ms[0].group, ms[0].motion, ms[0].truth, *(f"\n      {e} {'OK' if m.exact else '--'}: {m.failure or m.said}" for e, m in zip(engines, ms)))
