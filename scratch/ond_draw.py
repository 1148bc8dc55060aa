"""Draw proof cases once: python ond_draw.py SEED CASES MORE -> ond-draws/SEED/{case,more}_NNNN/ and truth .json"""
import json, sys, time
from pathlib import Path
from deltactl.proof.cases import draw, draw_more, write_blind
from deltactl.proof.prove.one_case import WITH_BOUND, _has_distance, as_recorded, bound, distance

seed, cases, more = map(int, sys.argv[1:4])
root = Path(f"ond-draws/{seed}")
order = [("case", n) for n in range(cases)] + [("more", n) for n in range(more)]
for stem, number in order:
    folder, truth_file = root / f"{stem}_{number:04d}", root / f"{stem}_{number:04d}.json"
    if truth_file.exists():
        continue
    begun = time.monotonic()
    case = draw(seed, number) if stem == "case" else draw_more(seed, number)
    truth = write_blind(case, folder, seed)
    drawn = time.monotonic() - begun
    still = as_recorded(case, truth) if case.group in WITH_BOUND else None
    truth_file.write_text(json.dumps({
        "seed": seed, "truth": case.truth(), "failure": None, "simulated_s": drawn,
        "bound": bound(case, still) if case.group in WITH_BOUND else None,
        "distance": distance(case, still) if _has_distance(case) else None,
    }, default=float))
    print(stem, number, case.group, round(time.monotonic() - begun, 1), flush=True)
