; written anew in the dialect of PrusaSlicer for Marlin
M73 P0 R12
M201 X1000 Y1000 Z200 E5000 ; sets maximum accelerations, mm/sec^2
M203 X200 Y200 Z12 E120
M205 X8.00 Y8.00 Z0.40 E4.50 ; jerk limits
M107
M862.3 P "MK3S" ; printer model check
M115 U3.13.0 ; firmware
G90 ; absolute
M83 ; extruder relative
M104 S215
M190 S60
G21 ; millimetres
G92 E0.0
M204 P800 R1250
M221 S95
;LAYER_CHANGE
;Z:0.2
G1 E-.8 F2100
G1 X12 Y10 Z.2 F10800
G1 E.8 F2100
;TYPE:Perimeter
G1 F1200
G1 X28 Y10 E.50178
G1 X28 Y24.5 E.45474
G2 X24.5 Y28 I0 J3.5 E.1
M73 P50 R6
G1 X12 Y28 E.39203
G1 X12 Y10.225 E.55745
M106 S127.5
G1 Z.4 F10800
G1 X20 Y20 E.2
M107
M84 X Y E ; disable motors
