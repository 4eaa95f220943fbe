"""Rows of the stress table on hulls: tables, read between their entries, against direct runs.

A direct run solves for the motions in SI units at frequencies and headings between those of the
tables, with capytaine's forces for just these waves and no interpolation. Mean squares of the
three accelerations at a place are compared. It needs the extra `hull`, and some minutes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from stress_cases import Row

from tauto_core.samples import FloatArray
from tauto_core.ship.hull import SHAPES, ClockPlace, Hull, HullCoefficients, Shape, named_hull
from tauto_core.ship.hull_bem import compute, form_mesh, solver
from tauto_core.ship.sea import bretschneider

HEADINGS = (0.35, 1.1, 1.9, 2.75)
DOFS = ('Surge', 'Sway', 'Heave', 'Roll', 'Pitch', 'Yaw')
DENSITY = 1025.0
ROLL_S, DAMPING = 11.0, 0.08


def _accelerations(mesh: Any, ship: Hull, omega: FloatArray, place: ClockPlace) -> FloatArray:
    """Return |acceleration| per metre of wave, (headings, n, 3), without tables.

    The weights are those of the ship; its centre of gravity lies in the waterline.
    """
    capytaine = solver()
    hull, g = ship.coefficients, ship.gravity
    half = mesh.generate_lid().clipped(origin=(0.0, 0.0, 0.0), normal=(0.0, -1.0, 0.0))
    body = capytaine.FloatingBody(
        mesh,
        dofs=capytaine.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)),
        center_of_mass=(0.0, 0.0, 0.0),
        lid_mesh=half.join_meshes(half.mirrored('xOz')),
    )
    m = DENSITY * mesh.disp_volume
    inertia = m * np.array([(0.38 * hull.beam) ** 2, *[(0.25 * hull.length) ** 2] * 2])
    mass = np.diag([m, m, m, *inertia])
    water = {'body': body, 'water_depth': np.inf, 'g': g, 'rho': DENSITY}
    engine = capytaine.BEMSolver()

    def radiated(w: float) -> tuple[FloatArray, FloatArray]:
        found = [
            engine.solve(capytaine.RadiationProblem(omega=w, radiating_dof=dof, **water))
            for dof in DOFS
        ]
        return (
            np.array([[each.added_mass[row] for each in found] for row in DOFS]),
            np.array([[each.radiation_damping[row] for each in found] for row in DOFS]),
        )

    natural = math.tau / ship.roll_period
    rolled = inertia[0] + radiated(natural)[0][3, 3]
    restoring = np.zeros((6, 6))
    restoring[2, 2] = DENSITY * g * hull.waterplane_area
    restoring[3, 3] = natural**2 * rolled
    restoring[4, 4] = (
        DENSITY * g * (hull.second_moments[1] + mesh.disp_volume * mesh.center_of_buoyancy[2])
    )
    found = np.empty((len(HEADINGS), len(omega), 3))
    for column, w in enumerate(omega):
        added, damping = radiated(w)
        damping[3, 3] += 2.0 * ship.roll_damping_ratio * natural * rolled
        matrix = -(w**2) * (mass + added) - 1j * w * damping + restoring
        for row, heading in enumerate(HEADINGS):
            wave = capytaine.DiffractionProblem(omega=w, wave_direction=heading, **water)
            pushed = capytaine.bem.airy_waves.froude_krylov_force(wave)
            scattered = engine.solve(wave).forces
            motion = np.linalg.solve(matrix, [pushed[dof] + scattered[dof] for dof in DOFS])
            x, y, z = place.forward, place.port, place.up
            moved = (
                motion[0] + z * motion[4] - y * motion[5],
                motion[1] + x * motion[5] - z * motion[3],
                motion[2] + y * motion[3] - x * motion[4],
            )
            found[row, column] = w**2 * np.abs(moved)
    return found


def _worst(mesh: Any, table: HullCoefficients) -> float:
    """Return the largest relative difference of the mean squares of the three accelerations."""
    # the unit of frequency is that of 44 m, so that the sea has waves of the hull's length
    unit = math.sqrt(9.80665 / table.length)
    ship = Hull(
        table,
        ROLL_S * math.sqrt(table.length / 44.0),
        DAMPING,
        # a box and Wigley's hull are no ships: their roll is what its period makes it
        centre_of_gravity=0.0,
    )
    place = ClockPlace(0.27 * table.length, 0.0, 0.07 * table.length)
    random = np.random.default_rng(7)
    omega = unit * np.sort(random.uniform(0.5, 4.7, 40))
    direct = _accelerations(mesh, ship, omega, place)
    energy = bretschneider(omega, 2.5, 9.0 * math.sqrt(table.length / 44.0))
    worst = 0.0
    for row, heading in enumerate(HEADINGS):
        ours = np.abs(ship.response(omega, heading).accelerations(place))
        one, other = (
            np.trapezoid(energy[:, None] * each**2, omega, axis=0) for each in (ours, direct[row])
        )
        worst = max(worst, float(np.max(np.abs(one - other) / other)))
    return worst


def direct_runs() -> list[Row]:
    """Compare a box, Wigley's hull and a shipped shape with direct runs."""
    name = 'mean squares of three accelerations against a direct run, relative'
    capytaine = solver()
    box = capytaine.mesh_parallelepiped(
        size=(44.0, 12.6, 10.0), resolution=(24, 8, 8), center=(0.0, 0.0, 0.0)
    ).immersed_part()
    wigley = form_mesh(Shape(44.0, 4.4, 2.75, 4.0 / 9.0), 28, 7)
    shipped = form_mesh(SHAPES['deptford'], 32, 8)
    return [
        Row(name, 'box 44 x 12.6 x 5 m', _worst(box, compute(box, 'box')), 0.01),
        Row(name, "Wigley's hull", _worst(wigley, compute(wigley, 'Wigley')), 0.01),
        Row(name, 'deptford, another mesh', _worst(shipped, named_hull('deptford')), 0.03),
    ]
