"""Build script: colcon reads it, pip reads it through setuptools."""

import runpy
from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'tauto_core'
VERSION = runpy.run_path(f'{PACKAGE}/version.py')['BASE']

TEST = [
    'boule>=0.5',  # normal gravity, by another formula
    'colcon-common-extensions>=0.3',
    'colcon-defaults>=0.2.9',
    'colcon-ros>=0.5',
    'gpxpy>=1.5',
    'h5netcdf>=1.3',
    'h5py>=3.11',
    'hypothesis>=6.100',
    'ipykernel>=6.29',
    'jsonschema>=4.20',
    'mpmath>=1.3',
    'nbclient>=0.10',
    'numba>=0.62',  # the same kernels through another compiler, bit for bit
    'pandas>=2.2',
    'psutil>=5.9',  # which sockets are open
    'pyarrow>=16.0',
    'pytest>=8.0',
    'pytest-cov>=5.0',
    'pytest-xdist>=3.8',
    'wheel>=0.40',
    'xarray>=2024.6',
]
LINT = [
    'import-linter>=2.1',
    'mypy>=1.15',
    'ruff>=0.17.5,<0.18',  # each minor release may format differently
    'scipy-stubs>=1.15',
    'types-PyYAML>=6.0.12',
    'types-jsonschema>=4.20',
]
# The documentation site; 0.x may change from release to release.
DOCS = [
    'ipykernel>=6.29',
    'mkdocstrings-python>=2.0.11',
    'nbconvert>=7.16',  # the lessons as pages
    'zensical>=0.0.73,<0.1',
]
# `Voyage.to_pandas` and `to_xarray`.
ARRAYS = ['pandas>=2.2', 'xarray>=2024.6']
# The lessons, which are notebooks.
NOTEBOOK = ['ipykernel>=6.29', 'nbclient>=0.10']
# Tracks as log-books.
GPX = ['gpxpy>=1.5']
# The rows of `tauto fleet --out`.
FLEET = ['pyarrow>=16.0']
# Weather and air of NetCDF along the track; NetCDF 3 needs xarray alone.
HINDCAST = ['h5netcdf>=1.3', 'h5py>=3.11', 'xarray>=2024.6']
# The coefficients of a hull, for `tauto hull`; the shapes that ship need nothing.
HULL = ['capytaine>=3.0']
# Wheel, cheeks and axle as solids, for `tauto cam`. It needs NumPy 2.
CAD = ['build123d>=0.13']
# The nodes, and the ROS 2 they need where none is installed.
ROS = [f'tauto_nodes[ros]=={VERSION}']

setup(
    name=PACKAGE,
    version=VERSION,
    description="Sully and Euler's sea clock on a rolling ship: curves, motion, drift, longitude.",
    long_description=Path('README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    author='The Tauto developers',
    license='Apache-2.0',
    license_files=['LICENSE', 'NOTICE'],
    keywords=['chronometer', 'longitude', 'isochronism', 'ROS 2', 'simulation'],
    classifiers=[
        'Development Status :: 4 - Beta',
        'Intended Audience :: Science/Research',
        'Operating System :: POSIX :: Linux',
        'Programming Language :: Python :: 3.11',
        'Programming Language :: Python :: 3.12',
        'Programming Language :: Python :: 3.13',
        'Topic :: Scientific/Engineering :: Physics',
        'Typing :: Typed',
    ],
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    package_data={
        PACKAGE: [
            'py.typed',
            'motion/gauss_coefficients.txt',
            'scene/shipped/*.yaml',
            'scene/data/*/*',
            'ship/hulls/*.npz',
            'scene/scene.schema.json',
            'ship/coasts.npz',
            'plots/report_page.html',
            'euler/site_page.html',
            'euler/*.yaml',
        ],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
    ],
    python_requires='>=3.11',
    install_requires=[
        'allantools>=2024.6',
        'ezdxf>=1.1',
        'geographiclib>=2.0',
        'llvmlite>=0.45',
        'loky>=3.5',
        'lz4>=4.3',
        'matplotlib>=3.7',
        'mcap>=1.1',
        'numpy>=1.26',
        'pillow>=10.0',
        'pydantic>=2.10',
        'pyyaml>=6.0.1',
        'rich>=13.7',
        'rosbags>=0.10.9',
        'scipy>=1.13',
        'typer>=0.16',
        'zstandard>=0.22',
    ],
    extras_require={
        'arrays': ARRAYS,
        'cad': CAD,
        'test': TEST,
        'dev': TEST + LINT + DOCS,
        'docs': DOCS,
        'fleet': FLEET,
        'gpx': GPX,
        'hindcast': HINDCAST,
        'hull': HULL,
        'notebook': NOTEBOOK,
        'ros': ROS,
    },
    entry_points={'console_scripts': ['tauto = tauto_core.cli:main']},
    zip_safe=False,
)
