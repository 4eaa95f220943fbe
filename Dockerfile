# Tauto on ROS 2 Jazzy, built as docs/howto/jazzy.md says; `docker run --rm tauto sail measured`.
FROM ros:jazzy

SHELL ["/bin/bash", "-o", "pipefail", "-c"]
WORKDIR /opt/tauto

# Ubuntu keeps only the newest patch of a package, so no version can be pinned here.
# hadolint ignore=DL3008
RUN apt-get update \
 && apt-get install --yes --no-install-recommends python3-venv python3-colcon-common-extensions \
      ros-jazzy-ros2launch ros-jazzy-rosbag2 ros-jazzy-rosbag2-storage-mcap \
 && rm -rf /var/lib/apt/lists/*

# What Ubuntu lacks; a layer that changes only with its list.
COPY requirements-jazzy.txt ./
RUN python3 -m venv --system-site-packages .venv-jazzy \
 && touch .venv-jazzy/COLCON_IGNORE \
 && .venv-jazzy/bin/pip install --no-cache-dir -r requirements-jazzy.txt

COPY src src
COPY ros_ws ros_ws
RUN source /opt/ros/jazzy/setup.bash \
 && apt-get update \
 && rosdep update \
 && rosdep install --from-paths src --ignore-src --default-yes --dependency-types exec \
 && rm -rf /var/lib/apt/lists/*
WORKDIR /opt/tauto/ros_ws
RUN source /opt/ros/jazzy/setup.bash \
 && source ../.venv-jazzy/bin/activate \
 && python -m colcon build

COPY .ci/entry /opt/tauto/entry
# Files are read and written where the caller mounts a folder: --volume "$PWD:/voyages"
WORKDIR /voyages
ENTRYPOINT ["/opt/tauto/entry"]
CMD ["--help"]
