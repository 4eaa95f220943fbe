"""Tauto as ROS 2 nodes, with their exceptions. Messages name thing, value, limit and remedy."""

from __future__ import annotations

from tauto_core.scene.errors import Argument, TautoError


class NodesError(TautoError):
    """Base of every error that tauto_nodes raises on purpose."""


class ParameterError(NodesError):
    """Parameters with which a node cannot start."""

    exit_code = 2


class GraphError(NodesError):
    """A graph that did not come up, stood still, or lost one of its nodes."""


def as_parameter(argument: Argument) -> str:
    """Return an argument as one writes it for a node or a launch file."""
    value = str(argument.value).lower() if argument.value is True else argument.value
    return f'{argument.name}:={"" if value is None else value}'
