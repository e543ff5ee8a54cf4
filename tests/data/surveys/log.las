~Version
 VERS. 2.0 : CWLS
 WRAP. NO : one line
~Well
 NULL. -999.25 : null
~Curve
 DEPT.M : depth
 DEVI.DEG : deviation
 HAZI.DEG : azimuth
 GR.API : gamma
~ASCII
0 0 40 -999.25
500 0.4 40 30
800 24 42 31
1400 88 47 32
