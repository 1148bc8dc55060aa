"""The lowest layer, which imports no other: errors, time, strict configuration.

Suffixes of names, used everywhere (a bare length or angle does not occur):

| suffix | unit |
|---|---|
| `_m`, `_mm`, `_um` | metre, millimetre, micrometre |
| `_rad`, `_deg` | radian, degree |
| `_s`, `_ms`, `_us`, `_ns` | second and its parts |
| `_hz` | per second |
| `_steps` | microsteps of a motor |
| `_kg`, `_kgm2` | kilogram, kilogram metre squared |
| `_n`, `_nm` | newton, newton metre |
| `_mps`, `_radps`, `_radps2` | metre per second, radian per second (squared) |
| `_mcps` | million counts per second (signal rate of a distance sensor) |
| `_c` | degree Celsius |
"""
