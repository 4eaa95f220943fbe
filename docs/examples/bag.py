"""Write a voyage as a bag, and read it back: estimates, and messages one by one."""

from rosbags.rosbag2 import Reader

import tauto_core as tauto

tauto.sail('second_cam_at_sea', duration=300.0).write('voyage_bag')

voyage = tauto.replay('voyage_bag')
print(voyage.answer)

with Reader('voyage_bag') as bag:
    for connection in bag.connections:
        print(f'{connection.msgcount:6d}  {connection.topic}  {connection.msgtype}')
