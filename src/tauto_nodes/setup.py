"""Build script: colcon reads it, pip reads it through setuptools."""

import sys
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'tauto_nodes'
VERSION = '0.3.0.dev0'
# colcon installs into a folder of the package, for `ros2 run`, and pip into the common bin/
PREFIX = '' if {'install', 'develop'}.intersection(sys.argv) else 'tauto-'

setup(
    name=PACKAGE,
    version=VERSION,
    description='ROS 2 Jazzy nodes of the sea clock: ship, trochlea, drift, longitude, bags.',
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
    package_data={PACKAGE: ['py.typed', 'simulation/*.xml']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/launch', glob('launch/*.py')),
        (f'share/{PACKAGE}/config', glob('config/*')),
        (f'share/{PACKAGE}/layouts', glob('layouts/*')),
        (f'share/{PACKAGE}/rviz', glob('rviz/*')),
        (f'share/{PACKAGE}/urdf', glob('urdf/*')),
    ],
    python_requires='>=3.11',
    install_requires=[f'tauto_core=={VERSION}'],
    extras_require={
        'ros': [
            'ros-jazzy-common-interfaces>=5.3.6',
            'ros-jazzy-rclpy>=7.1.4',
            'ros-jazzy-rmw-fastrtps-cpp>=8.4.3',
        ],
        # colcon looks for pytest here.
        'test': ['hypothesis>=6.100', 'pytest>=8.0'],
    },
    entry_points={
        'console_scripts': [
            f'{PREFIX}{node} = {PACKAGE}.{module}:{node}'
            for module, nodes in (
                ('live.stages', ('trochlea', 'drift_estimator', 'longitude')),
                ('live.recorder', ('recorder',)),
                ('live.player', ('player',)),
                ('live.markers', ('markers',)),
                ('simulation.ship', ('ship_motion',)),
                ('commands', ('launch_plan',)),
            )
            for node in nodes
        ],
        'tauto.commands': [f'graph = {PACKAGE}.commands:graph', f'play = {PACKAGE}.commands:play'],
    },
    zip_safe=False,
)
