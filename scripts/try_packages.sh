# scripts/make_deb.sh --try runs this in a system with the Debian packages installed: it drives a simulated robot, then a fleet of 4.
export ROS_IP=127.0.0.1 ROS_HOME=/tmp/try
rm -rf $ROS_HOME  # left by an earlier run
as_shipped=$PATH PATH=/usr/lib/node_lifecycle:$PATH
trap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT

say() { printf '   %s\n' "$*"; }
heard() { timeout 60 rostopic echo -n 1 "$@" >/dev/null || { echo "no message arrived: rostopic echo $*" >&2; tail -20 /tmp/launch.log >&2; exit 1; }; }

say "one robot: roslaunch omron_ld90 full_stack.launch"
roslaunch omron_ld90 full_stack.launch >/tmp/launch.log 2>&1 &
until rosnode list 2>/dev/null | grep -q omron_controller; do kill -0 $!; sleep 0.5; done
heard /omron_ld90/robot_status
refuses_browsers() { [ "$(answer_to_a_browser "$1")" = 403 ] || { echo "the ROS master $2 obeys web browsers" >&2; exit 1; }; }
answer_to_a_browser() { /usr/bin/python3 -I -c 'import sys, urllib.request, urllib.error
try: print(urllib.request.urlopen(urllib.request.Request(sys.argv[1], b"x", {"Origin": "null"})).status)
except urllib.error.HTTPError as error: print(error.code)' "$1"; }
refuses_browsers http://127.0.0.1:11311 "of roslaunch"
rostopic pub -1 /omron_ld90/send_command std_msgs/String 'goto 12' >/dev/null
heard --filter "m.status == 'Arrived at 12'" /omron_ld90/robot_status
say "it has arrived"
kill -INT $!; wait $! || true

say "a fleet: rosrun fleet_bringup fleet_launch fleet:=2 longest_edge:=1.5"
roslaunch "$(rosrun fleet_bringup fleet_launch fleet:=2 longest_edge:=1.5)" >/tmp/launch.log 2>&1 &
until rosnode list 2>/dev/null | grep -q path_supervisor; do kill -0 $!; sleep 0.5; done
heard --filter "len(m.robots) == 4 and all(robot.state < 2 for robot in m.robots)" /fleet_state
rosrun graph_fleet_manager mission 18 39 --wait
say "its mission has succeeded"
kill -INT $!; wait $! || true

say "services of a site: rosrun fleet_services install_service"
mkdir -p /tmp/site
printf 'name: hall\nuser: fleet\narguments:\n  fleet: 2\n  longest_edge: 1.5\n' >/tmp/site/site.yaml
PATH=$as_shipped rosrun fleet_services install_service --root /tmp/machine /tmp/site/site.yaml
unit=/tmp/machine/etc/systemd/system/fleet-hall-master.service
(set -a; . /tmp/machine/etc/fleet/hall/environment; exec $(sed -n 's/^ExecStart=//p' $unit)) >/tmp/master.log 2>&1 &
until ROS_MASTER_URI=http://127.0.0.1:11311 rosparam list >/dev/null 2>&1; do kill -0 $!; sleep 0.5; done
refuses_browsers http://127.0.0.1:11311 "of the units"
say "the master of its units refuses browsers"
kill -INT $!; wait $! || true
