"""A voyage as one HTML page: the answer, the map, the moving ship with its clock, the charts."""

from __future__ import annotations

import json
import math
import platform
import re
from html import escape
from importlib.metadata import version
from io import StringIO
from pathlib import Path
from string import Template
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from tauto_core.curves.fluid import coordinates
from tauto_core.ensembles.budget import kept_budget
from tauto_core.files import LOOK, check_place, write_output
from tauto_core.machines import FluidPendulum, LeverMachine, compile_machine
from tauto_core.machines.threads import HoleThread
from tauto_core.machines.threads.lever import LeverThread
from tauto_core.plots.chart import COLOURS, LAND, MAP_RATIO, Chart, draw
from tauto_core.plots.contents import PART_S, PICTURES, chart, map_samples, seaway, window
from tauto_core.plots.machine import MM, draw_machine, fulcrum_mm
from tauto_core.results import SIGNS, budget_rows, damage_sentence, groups
from tauto_core.samples import FloatArray
from tauto_core.scene import scene_yaml
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.scene.times import DAY_S
from tauto_core.ship.coast import land
from tauto_core.version import code
from tauto_core.version import version as tauto_version
from tauto_core.voyage import Voyage
from tauto_core.wording import figure, span

# -----------------------------------------------------------------------------
# The data of the moving machine in a report: outlines, and its motion in ten minutes.

_ROLL_STEP_S = 0.25


def animation(voyage: Voyage) -> dict[str, Any]:
    """Return outlines and motion for JSON, or the reason `why` they are missing.

    The angle of the wheel, or the arc of a body in a fluid, is A cos φ. Phase φ and amplitude A
    are interpolated between logged samples, which may be a minute apart.

    Returns:
        lines: outlines, each with `name`, `x`, `y` [mm, y upwards], `colour`, `area`, and `with`,
            the part with which it moves (`machine.Carrier`). `note` explains them.
        which: the choice of the part that is shown, or empty for a short voyage.
        from_s, length_s: the part. At logged samples it has `time_s` within the part, `phase_rad`,
            `amplitude_rad` and the dial's `error_s`, and every `roll_step_s` `heave_m`, `roll_rad`
            and `plumb_rad`, the apparent vertical. `true_s` is the true time of day at its start.
        hangs, fixed_end: whether the thread follows `plumb_rad`, and whether its end is fixed.
        winding: `angle_rad`, and `x`, `y` of the contact in the wheel's frame and `rise` [mm].
        pivot, lever: of a suspended case [mm]; `x`, `y` of the fulcrum, `beta_rad` at `angle_rad`.
        curve: in a fluid, `x`, `y` [mm] at `arc_m`. These four are null if there are none.
    """
    scene = voyage.scene
    if not len(voyage.angle_rad) or not len(voyage.phase_rad):
        return {'why': 'The bag does not hold the motion of the machine.'}
    machine = compile_machine(scene)
    size = np.hypot(voyage.angle_rad, voyage.angular_velocity_rad_s / machine.frequency)
    drawn, hung, trochlea = draw_machine(scene), scene.suspension, scene.trochlea
    thread = None if trochlea is None else trochlea.thread
    weight = trochlea is not None and trochlea.power.pull.pulling_mass > 0.0
    fixed_end = isinstance(thread, HoleThread | LeverThread)
    lever: dict[str, Any] | None = None
    curve: dict[str, Any] | None = None
    if isinstance(machine, LeverMachine) and isinstance(thread, LeverThread):
        # the fulcrum is at the height of the thread's drawn end
        (drawn_thread,) = (part for part in drawn.parts if part.name == 'thread')
        shape, fulcrum = machine.geometry, fulcrum_mm(thread)
        low, high = (0.999 * side for side in machine.sides)
        angle = np.linspace(low, high, 201)
        lever = {
            'x': fulcrum[0],
            'y': float(drawn_thread.y[-1]) + fulcrum[1],
            'angle_rad': _rounded(angle, 4),
            # from the drawn lever, at rest
            'beta_rad': _rounded(shape.side * (machine.beta(angle) - shape.inclination), 5),
        }
    elif isinstance(machine, FluidPendulum):
        # to the largest possible arc of release
        cusp = machine.curve.descent_cusp
        arc = np.linspace(-min(-machine.curve.ascent_cusp, cusp), cusp, 201)
        height, level = coordinates(machine.curve, arc)
        curve = {'arc_m': _rounded(arc, 5), 'x': _rounded(MM * level), 'y': _rounded(MM * height)}
    winding: dict[str, Any] | None = None
    if trochlea is not None and trochlea.cam.kind != 'lever_corrected':
        cam = trochlea.made_cam(scene.g)
        angle = np.linspace(0.0, cam.drawn_rad, 101)
        arm, (x, y) = cam.lever_arm(angle), cam.contact(angle)
        rise = np.concatenate(([0.0], np.cumsum(0.5 * (arm[1:] + arm[:-1]) * np.diff(angle))))
        sizes = {'x': x, 'y': y, 'rise': rise}
        winding = {name: _rounded(MM * size) for name, size in sizes.items()}
        winding['angle_rad'] = _rounded(angle, 4)
    # from the last logged sample before the roughest ten minutes on
    rough = window(voyage, None, None)
    begin = max(int(np.searchsorted(voyage.time_s, rough.from_s, side='right')) - 1, 0)
    began_s = float(voyage.time_s[begin])
    end = int(np.searchsorted(voyage.time_s, began_s + PART_S, side='right'))
    part = slice(begin, max(end, begin + 2))
    time_s = voyage.time_s[part] - began_s
    length_s = float(time_s[-1])
    ship = seaway(voyage, began_s, length_s + 1.0)
    grid = np.arange(0.0, length_s + _ROLL_STEP_S, _ROLL_STEP_S)
    moves = {'roll_rad': ship.roll_rad, 'plumb_rad': ship.plumb_rad, 'heave_m': ship.heave_m}
    return {
        'lines': [
            {
                'name': part.name,
                'x': _rounded(part.x),
                'y': _rounded(part.y),
                'colour': part.colour,
                'area': part.kind == 'area',
                'with': part.moves_with,
            }
            for part in drawn.parts
        ],
        'note': drawn.note,
        'roll_step_s': _ROLL_STEP_S,
        'which': rough.note,
        'from_s': round(began_s, 3),
        'length_s': round(length_s, 3),
        'time_s': _rounded(time_s, 3),
        'phase_rad': _rounded(voyage.phase_rad[part], 4),
        'amplitude_rad': _rounded(size[part], 4),
        'error_s': _rounded(voyage.clock_error_s[part], 3),
        'true_s': round(voyage.start_ns * 1e-9 % DAY_S + began_s, 3),
        **{
            name: _rounded(np.interp(grid, ship.time_s - began_s, values), 4)
            for name, values in moves.items()
        },
        'hangs': weight and not fixed_end and hung is None,
        'fixed_end': fixed_end,
        'winding': winding,
        'pivot': None if hung is None else [0.0, MM * hung.depth],
        'lever': lever,
        'curve': curve,
    }


def _rounded(values: FloatArray, digits: int = 3) -> list[float]:
    listed: list[float] = np.round(values, digits).tolist()
    return listed


# -----------------------------------------------------------------------------
# Ship and dials as SVG.
#
# Each function returns a fragment. Colours are CSS variables (`--land`, `--ink`, `--blue`, …),
# which the page sets for light and dark. Moving parts have an id or a class.

INK = {
    'light': {
        'ink': '#1b1b1b',
        'soft': '#595959',
        'paper': '#ffffff',
        'rule': '#d0d0d0',
        'land': '#e4dfd3',
        'sea': '#eaf2f7',
        'water': '#b9d6e6',
        'blue': '#0072b2',
        'orange': '#c05200',
        'green': '#00785a',
        'grey': '#767676',
        'wood': '#8a6a48',
        'sail': '#f6f1e4',
    },
    'dark': {
        'ink': '#ededed',
        'soft': '#b4b4b4',
        'paper': '#141414',
        'rule': '#444444',
        'land': '#3a382f',
        'sea': '#17222a',
        'water': '#25475a',
        'blue': '#56b4e9',
        'orange': '#e69f00',
        'green': '#2fcf9f',
        'grey': '#9a9a9a',
        'wood': '#a98760',
        'sail': '#cfc9b8',
    },
}
"""Colours of a picture on white and on black paper, from the palette of Okabe and Ito."""


def variables(scheme: str) -> str:
    """Return the colours as CSS variables."""
    return ' '.join(f'--{name}: {colour};' for name, colour in INK[scheme].items())


# -----------------------------------------------------------------------------
# The ship, seen from ahead, and the face of a clock

SHIP_WIDTH = 320.0
"""Width of the picture of the ship."""
SHIP_HEIGHT = 260.0
_CLOCK_AT = (160.0, 168.0)


def ship() -> str:
    """Return ship and sea from ahead. The page moves `ship-hull` and redraws the water.

    The ship is a midship section with wales and deck, a mast with two yards and sails, and the
    clock amidships.
    """
    x, y = _CLOCK_AT
    hull = 'M108,152 C106,188 126,212 160,216 C194,212 214,188 212,152 L206,146 L114,146 Z'
    return (
        f'<rect width="{SHIP_WIDTH}" height="{SHIP_HEIGHT}" fill="var(--sea)"/>'
        '<path id="water-far" class="water" opacity="0.45"/>'
        '<g id="ship-hull">'
        '<path d="M160,146 V18" stroke="var(--wood)" stroke-width="5"/>'
        '<path d="M112,58 Q160,66 208,58 L202,96 Q160,106 118,96 Z" fill="var(--sail)" '
        'stroke="var(--soft)"/>'
        '<path d="M128,26 Q160,32 192,26 L188,52 Q160,59 132,52 Z" fill="var(--sail)" '
        'stroke="var(--soft)"/>'
        '<path d="M106,57 H214 M124,25 H196" stroke="var(--wood)" stroke-width="3.5"/>'
        '<path d="M160,24 L112,148 M160,24 L208,148" stroke="var(--soft)" stroke-width="0.8"/>'
        '<path d="M160,18 q12,-3 22,2 q-10,5 -22,4 Z" fill="var(--orange)"/>'
        f'<path d="{hull}" fill="var(--wood)" stroke="var(--ink)" stroke-width="1.5"/>'
        '<path d="M109,163 Q160,171 211,163 M112,178 Q160,187 208,178" fill="none" '
        'stroke="var(--ink)" stroke-width="0.8" opacity="0.6"/>'
        f'<circle cx="{x}" cy="{y}" r="12" fill="var(--paper)" stroke="var(--ink)" '
        'stroke-width="1.5"/>'
        f'<path d="M{x},{y} v-8 M{x},{y} h5" stroke="var(--blue)" stroke-width="2" '
        'stroke-linecap="round"/></g>'
        '<path id="water-near" class="water" opacity="0.8"/>'
    )


def dial(name: str, label: str, colour: str) -> str:
    """Return the face of a clock about (0, 0), of radius 46, with hands at noon.

    The hands are the groups `{name}-hour`, `{name}-minute` and `{name}-second`.
    """
    ticks = []
    for k in range(60):
        turn, inner = math.radians(6.0 * k), 38.0 if k % 5 == 0 else 41.5
        s, c = math.sin(turn), -math.cos(turn)
        ticks.append(f'M{inner * s:.1f},{inner * c:.1f}L{44.0 * s:.1f},{44.0 * c:.1f}')
    hands = ''.join(
        f'<g id="{name}-{hand}"><path d="M0,{tail}V{-length}" stroke="{stroke}" '
        f'stroke-width="{width}" stroke-linecap="round"/></g>'
        for hand, tail, length, width, stroke in (
            ('hour', 0, 22, 4.5, 'var(--ink)'),
            ('minute', 0, 34, 3.0, 'var(--ink)'),
            ('second', 8, 40, 1.2, f'var(--{colour})'),
        )
    )
    return (
        f'<circle r="46" fill="var(--paper)" stroke="var(--{colour})" stroke-width="3"/>'
        f'<path d="{"".join(ticks)}" stroke="var(--soft)" stroke-width="1" fill="none"/>'
        f'{hands}<circle r="3" fill="var(--ink)"/>'
        f'<text class="dial-label" y="62" text-anchor="middle">{escape(label)}</text>'
    )


# -----------------------------------------------------------------------------
# The page. It contains everything, and uses no network.

WIDE_IN, MAP_IN, NARROW_IN = 12.0, 9.0, 6.4
"""Width of a chart in the story, of the map, and of a chart of a pair [in]."""


def check_report(file: Path) -> None:
    """Refuse a file to which a report cannot be written.

    UsageError: the suffix is not .html, or `check_place` refuses the file.
    """
    if file.suffix != '.html':
        raise UsageError(Argument('file', file), ': must end in .html. Name another file')
    check_place(file, 'file')


def write_report(voyage: Voyage, file: Path, command: str) -> None:
    """Write the page of a voyage, with the command line that made it, and replace the file.

    Raises:
        UsageError: see `check_report`.
        OutputError: the file cannot be written.
    """
    check_report(file)
    text = report_html(voyage, command)
    # the command may name a file whose name is not text
    write_output(file, text.encode('utf-8', 'xmlcharrefreplace'))


SUBJECTS = {
    'The longitude': ('longitude', 'drift', 'stability'),
    'The machine': ('machine', 'cam', 'amplitude', 'phase'),
    'The sea and the air': ('roll', 'spectrum', 'temperature'),
}
"""The folded charts below the story, by subject."""
STORY = ('error', 'weather', 'rate')
"""The visible charts below map and ship, in this order."""
LEAST_MAP_DEG = 0.1
"""Smallest extent of the tracks for a map without land [°]."""
MARKS = (('by the dial', 'blue'), ('corrected', 'orange'), ('the ship', 'green'))
"""Tracks of the moving marks of the map, from the back to the front, and their colours."""
_MARKER_STEPS = 240


_BODY = {
    (False, False): 'The ship in the sea, and its clock',
    (False, True): 'The ship in the sea, and the body on its curve',
    (True, False): 'The clock',
    (True, True): 'The body on its curve',
}
"""Heading of the moving picture, by whether the ship is at rest and whether there is a curve."""


def report_html(voyage: Voyage, command: str) -> str:
    """Return the page of a voyage, with the command line that made it."""
    charts, missing = {}, {}
    for name in PICTURES:
        try:
            charts[name] = chart(voyage, name)
        except UsageError as error:  # the voyage lacks its data
            missing[name] = f'Not drawn: {error}.'
    course, track = _map_section(voyage, charts.pop('map', None), missing.get('map', ''))

    def section(name: str, level: int, width_in: float) -> str:
        if name not in charts:
            return f'<p class="note">{escape(missing[name])}</p>'
        of = charts[name]
        words = ' '.join(panel.note for panel in of.panels if panel.note)
        notes = f'<p class="note">{escape(words)}</p>' if words else ''
        head = f'<section id="{name}"><h{level}>{escape(of.title)}</h{level}>'
        label = f'class="chart" role="img" aria-label="{escape(of.described)}"'
        return f'{head}<div {label}>{chart_svg(of, width_in)}</div>{notes}</section>'

    story = [section(name, 2, WIDE_IN) for name in STORY if name in charts]
    budget = voyage.result.get('bag') and kept_budget(Path(str(voyage.result['bag'])))
    if budget:
        story.append(_budget(budget))
    rows = []
    for name, content in groups(voyage.result):
        rows.append(f'<tr><th colspan="3" scope="rowgroup">{escape(name)}</th></tr>')
        for label, value, unit in content:
            cells = f'<td>{escape(label)}</td><td class="value">{escape(value)}</td>'
            rows.append(f'<tr>{cells}<td>{escape(unit)}</td></tr>')
    folded = [
        f'<details><summary>{subject}</summary><div class="pair">'
        f'{"".join(section(name, 3, NARROW_IN) for name in names)}</div></details>'
        for subject, names in SUBJECTS.items()
    ]
    programs = ('numpy', 'scipy', 'llvmlite', 'matplotlib')
    versions = [
        f'tauto_core {tauto_version()} (code {code()})',
        f'Python {platform.python_version()}',
        *(f'{name} {version(name)}' for name in programs),
    ]
    damage = escape(damage_sentence(voyage.result))
    seconds = voyage.result.get('duration_s')
    sentence, dot, remainder = voyage.answer.partition('. ')
    motion = animation(voyage)
    data = {'motion': motion, 'track': track}
    still = voyage.scene.lies_still
    template = Template(Path(__file__).with_name('report_page.html').read_text(encoding='utf-8'))
    return template.substitute(
        title=escape(voyage.scene.name),
        length='' if seconds is None else escape(f': {span(seconds)}'),
        light=variables('light'),
        dark=variables('dark'),
        damage=f'<p class="damage" role="alert">{damage}</p>' if damage else '',
        answer=escape(sentence + dot.rstrip()),
        more=escape(remainder),
        about=escape(_about(voyage)),
        course=course,
        moving=_BODY[still, motion.get('curve') is not None],
        place='on-land' if still else 'at-sea',
        ship=''
        if still
        else f'<svg id="ship-view" viewBox="0 0 {SHIP_WIDTH:g} {SHIP_HEIGHT:g}" role="img" '
        'aria-label="The ship, seen from ahead, rolls and heaves in the sea">'
        f'{ship()}</svg>',
        dials=f'<g transform="translate(56,54)">{dial("true", "true time", "green")}</g>'
        f'<g transform="translate(184,54)">{dial("dial", "the dial", "blue")}</g>',
        signs=escape(SIGNS),
        figures='\n'.join(rows),
        story='\n'.join(story),
        folded='\n'.join(folded),
        shown=json.dumps(data, separators=(',', ':'), allow_nan=False),
        scene=escape(scene_yaml(voyage.scene)),
        made=f'<code>{escape(command)}</code><br>{escape(", ".join(versions))}',
    )


_WORKS = {
    'fluid_tautochrone': "A body on Euler's curve of 1729 in a fluid",
    'axle': "Euler's pendulum of 1780 on an axle",
    'involute': "Sully's clock of 1726 with Euler's cam of 1727",
    'hole': "Sully's clock of 1726 with Euler's second cam of 1727",
    'circular_arc': "Sully's clock of 1726 with cheeks of circular arcs",
}
"""Subject of a page, by the kind of its regulator or cam."""


def _about(voyage: Voyage) -> str:
    """Return the subject of the page, and the meaning of "rated and corrected" in its answer."""
    part = voyage.scene.regulator or (voyage.scene.trochlea and voyage.scene.trochlea.cam)
    work = _WORKS.get(getattr(part, 'kind', ''), "Sully's clock of 1726 with a cam after Euler's")
    words = (
        ' Rated and corrected: the navigator measured the rate of the dial while he knew the true '
        'time, and subtracts the error that it has caused since.'
    )
    return f'{work}, simulated by Tauto.{words * ("rated and corrected" in voyage.answer)}'


def _map_section(
    voyage: Voyage, of: Chart | None, why: str
) -> tuple[str, dict[str, list[float]] | None]:
    """Return the map as a section of the page, and the places of its moving marks.

    The places of the ship, true, by the dial and by the corrected clock, are in units of the
    picture, with their days and both errors [nmi].
    """
    if of is None:
        return f'<section id="map"><p class="note">{escape(why)}</p></section>', None
    tracks = {line.name: line for line in of.lines if line.kind == 'line'}
    shown_deg = max(float(np.ptp(getattr(line, axis))) for line in of.lines for axis in 'xy')
    if shown_deg < LEAST_MAP_DEG and not land(of.frame(MAP_RATIO)):
        # the map would be an empty sea
        return '', None
    figure = draw(of, width_in=MAP_IN)
    picture = _svg(figure, 'map')
    marks = [mark for mark in MARKS if mark[0] in tracks]
    moving = ''.join(
        f'<g id="mark-{colour}" class="mark"><circle r="6" fill="var(--{colour})" '
        f'stroke="var(--paper)" stroke-width="1.5"/></g>'
        for _, colour in marks
    )
    which = np.linspace(0, len(tracks['the ship'].x) - 1, _MARKER_STEPS).round().astype(int)
    part = map_samples(voyage)
    places = {'day': _rounded(voyage.time_s[part][which] / DAY_S, 3)}
    for name, colour in marks:
        ends = np.column_stack([tracks[name].x[which], tracks[name].y[which]])
        # points of the SVG, y downwards
        x, y = (figure.axes[0].transData.transform(ends) * (72.0 / figure.dpi)).T
        places |= {
            f'{colour}_x': _rounded(x, 1),
            f'{colour}_y': _rounded(72.0 * figure.get_figheight() - y, 1),
        }
    if len(marks) > 1:
        for name, miles in (
            ('dial_nmi', voyage.raw_longitude_error_nmi),
            ('error_nmi', voyage.longitude_error_nmi),
            ('sigma_nmi', voyage.longitude_sigma_nmi),
        ):
            places[name] = _rounded(miles[part][which], 2)
    controls = (
        '<div class="controls"><button id="sail" type="button">Pause</button>'
        '<input id="day" type="range" min="0" max="1" step="any" value="0" '
        'aria-label="day of the voyage"><output id="when" for="day"></output></div>'
    )
    label = f'class="chart" role="img" aria-label="{escape(of.described)}"'
    picture = f'<div {label}>{picture.replace("</svg>", f"{moving}</svg>")}</div>'
    return f'<section id="map">{picture}{controls}</section>', places


def _budget(facts: dict[str, Any]) -> str:
    """Return the budget kept with a voyage as a section, with a bar for each cause."""
    every = (*facts['rows'], facts['sum'], facts['interaction'], facts['whole'])
    sizes = [abs(row['rate_s_per_day']) for row in every]
    widest = max(sizes, default=0.0) or 1.0
    rows = []
    for size, cells in zip(sizes, budget_rows(facts), strict=True):
        bar = f'<meter min="0" max="1" value="{size / widest:.4f}"></meter>'
        cause, rate, miles, where = map(escape, cells)
        values = f'<td class="value">{rate}</td><td class="value">{miles}</td>'
        rows.append(f'<td>{cause}</td>{values}<td>{where}</td><td>{bar}</td>')
    numbers = '<th class="value">s/day</th><th class="value">nmi at the end</th>'
    head = f'<th>cause</th>{numbers}<th>found</th><th></th>'
    table = ''.join(f'<tr>{row}</tr>' for row in rows)
    fixed, sailed = facts['fixed_s_per_day'], facts['sailed']
    words = (
        f'{sailed[0].upper()}{sailed[1:]}. Badly known numbers leave an uncertainty '
        f'of ± {figure(facts["rough_s_per_day"], "s/day")} s/day.'
    )
    if fixed is not None:
        words += f' With its case fixed to the ship: {figure(fixed, "s/day", signed=True)} s/day.'
    return (
        '<section id="budget"><h2>The causes of the rate</h2>'
        f'<table><tr>{head}</tr>{table}</table><p class="note">{escape(words)}</p></section>'
    )


def chart_svg(of: Chart, width_in: float) -> str:
    """Return a chart as an SVG element, in the colours of the page."""
    return _svg(draw(of, width_in=width_in), of.title)


def _svg(figure: Figure, name: str) -> str:
    """Return a figure as an SVG element, with names of clips and marks that no other one has."""
    written = StringIO()
    with mpl.rc_context(LOOK | {'svg.hashsalt': name}):
        figure.savefig(written, format='svg', transparent=True, metadata={'Date': None})
    text = written.getvalue()
    # the style sheet within would hold for the page
    unwanted = r'<metadata>.*?</metadata>|<style .*?</style>| id="[\w.]+_\d+"'
    text = re.sub(unwanted, '', text[text.index('<svg') :], flags=re.S)
    return re.sub('|'.join(_DRAWN), lambda at: f'var(--{_DRAWN[at[0]]})', text)


_DRAWN = {colour: name for name, colour in COLOURS.items()} | {
    '#000000': 'ink',
    '#ffffff': 'paper',
    '#999999': 'rule',
    LAND: 'land',
}
"""Colours of a drawn chart, and their variables."""
