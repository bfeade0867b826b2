# A simulated robot, a fleet, or the stack of a real robot in a container: Debian 12 and an unprivileged user.
#
#   docker build -t omron_ld90 .
#   docker run --rm --read-only --tmpfs /tmp -v omron_ld90:/data --network host omron_ld90 fleet:=4 longest_edge:=1.5 demo:=true
#
# The arguments are those of scripts/run.sh. Everything that must survive a restart (journals, logs, maps) is written to /data.
# ROS nodes and robots open connections to each other: they need the network of the host.
FROM debian:12-slim
WORKDIR /opt/omron_ld90
COPY . .
RUN scripts/build.sh && \
    apt-get clean && rm -rf /var/lib/apt/lists/* && \
    python3 -I -m compileall -q src devel && \
    useradd --uid 900 --create-home --home-dir /data ld90
# A volume lasts: what a node could write there must not run as a part of Python in the next start.
ENV HOME=/data ROS_HOME=/data/ros PYTHONNOUSERSITE=1 PYTHONSAFEPATH=1
VOLUME /data
USER 900
ENTRYPOINT ["/opt/omron_ld90/scripts/run.sh"]
