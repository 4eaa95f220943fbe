"""Print the page of the topics, made from their table: python docs/topics.py.

`make docs` writes it to docs/topics.md.
"""

from __future__ import annotations

import sys

from tauto_core.bags.table import MESSAGE_TYPES, TOPICS, MessageType

_HEAD = """# Topics

**`trochlea/phase`, `drift/estimate` and `longitude/error` carry named scalars with a stamp as
`sensor_msgs/JointState`: `position` holds the values that `name` names; they are not joints.** Do
not subscribe a `robot_state_publisher` to them; only `trochlea/joint_states` describes a joint.

JointState is part of every ROS 2 installation and has a stamp, names and any number of doubles;
plotting tools label its curves by the names. The alternatives are worse:

- `diagnostic_msgs/KeyValue` has no stamp and carries numbers as text.
- `Vector3Stamped` has no names and holds three values of one frame, not five of different units.
- `Float64` would need four or five topics, and has no stamp by which to join them.
- A `tauto_msgs` package would need generated code, which pip cannot build, on every
  machine that only wants to open a bag.

Topic names are relative, so a clock in a namespace has all of them in that namespace. Only
standard messages are used. Every publisher is RELIABLE and KEEP_LAST; a latched topic is
TRANSIENT_LOCAL, the others are VOLATILE; deadline, lifespan and liveliness are infinite. In a bag
the log time of a message is its stamp; `scene`, which has no header, has the stamp of the start.

`make docs` makes this page from `tauto_core/bags/table.py`.

| topic | type | from | depth | latched | meaning |
|---|---|---|---|---|---|
"""

_FIELDS = """
## Fields

A batch of n samples has one array for each field, whose first axis is the sample. A field marked
"batch" has one value for the whole batch.
"""


def topic_reference() -> str:
    """Return the topic reference as Markdown."""
    rows = [
        f'| `{topic.name}` | {topic.ros_type} | {topic.node} | {topic.depth} | '
        f'{"yes" if topic.latched else "no"} | {topic.meaning} |\n'
        for topic in TOPICS.values()
    ]
    return ''.join([_HEAD, *rows, _FIELDS, *map(_fields, MESSAGE_TYPES.values())])


def _fields(message: MessageType) -> str:
    lines = ['| message field | sample field | holds | unit |', '|---|---|---|---|']
    for field in message.fields:
        kind = f'{field.length} × {field.kind}' if field.length > 1 else field.kind
        kind += ', batch' if field.shared else ''
        lines.append(f'| `{field.message}` | `{field.sample}` | {kind} | {field.unit} |')
    rows = '\n'.join(lines)
    return f'\n### {message.name}: `{message.samples.__name__}`\n\n{rows}\n'


if __name__ == '__main__':
    sys.stdout.write(topic_reference())
