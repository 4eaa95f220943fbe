"""Design a cam for a weight that has inertia, see that it keeps time, and write its outline."""

import numpy as np

import tauto_core as tauto

scene = tauto.load('involute_weight_at_sea')
trochlea = scene.trochlea.model_dump()
trochlea['cam'] = {'kind': 'weight_corrected', 'period': 1.0}
corrected = tauto.load(scene, trochlea=trochlea, clock={'nominal_period': 1.0})

for name, each in (('involute', scene), ('corrected', corrected)):
    print(name, tauto.isochronism(each, [0.2, 0.6, 1.0]), sep=': ')

outline = tauto.cam(corrected, points=200)
np.savetxt('cam.csv', np.column_stack([outline.x_m, outline.y_m]), header='x_m,y_m', delimiter=',')
