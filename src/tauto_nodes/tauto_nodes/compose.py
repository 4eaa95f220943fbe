"""All nodes of the graph in one process: `tauto graph --compose`."""

from __future__ import annotations

from tauto_nodes.drift_estimator import DriftEstimator
from tauto_nodes.longitude import Longitude
from tauto_nodes.recorder import Recorder
from tauto_nodes.running import main_of
from tauto_nodes.ship_motion import ShipMotion
from tauto_nodes.trochlea import Trochlea

main = main_of(Recorder, Longitude, DriftEstimator, Trochlea, ShipMotion)

if __name__ == '__main__':
    main()
