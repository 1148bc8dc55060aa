%
(1001)
(written anew in the dialect of Fusion 360 for grbl)
(T1  D=3 CR=0 - ZMIN=-1 - flat end mill)
G90 G94
G17
G21

(2D Contour1)
T1
S12000 M3
G54
G0 X21.3 Y-1.65
Z15
Z5
G1 Z1 F333.3
Z-0.7
Y-1.5 F1000
G17 G3 X20 Y-0.2 I-1.3 J0
G1 X2
G2 X0 Y1.8 I0 J2
G1 Y10
G0 Z15
M5
X0 Y0
M30
%
