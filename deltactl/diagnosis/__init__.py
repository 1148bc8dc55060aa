"""Where model and recording differ: detect, locate, name, size, decide, report.

In: recordings and a robot file. Out: a `Diagnosis`. `api.diagnose` is the one way in; the folders
in the order in which a recording passes them: `observations`, `admission`, `plants`, `pipelines`;
then `priors`, `evidence`, `selection`, `assessment`; at the end `experiment`, `answer`, `report`.
"""
