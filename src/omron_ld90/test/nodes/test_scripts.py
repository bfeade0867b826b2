"""A user's first commands: what they say if they cannot continue."""
from __future__ import annotations

import os
import pty
import pwd
import re
import shutil
import socket
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]


def run(*args: str, folder: Path = ROOT) -> subprocess.CompletedProcess:
    return subprocess.run([str(ROOT / 'scripts' / 'run.sh'), *args], cwd=folder, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120,
                          check=False)


@pytest.fixture
def taken_port():
    with socket.socket() as holder:
        holder.bind(('127.0.0.1', 0))
        holder.listen()
        yield holder


@pytest.fixture
def free_port():
    # the port is bound, so that no other program can use it; but no program listens
    with socket.socket() as holder:
        holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        holder.bind(('127.0.0.1', 0))
        yield holder.getsockname()[1]


@pytest.mark.parametrize('argument, other', [
    ('arcl_port', 'outgoing_port'), ('outgoing_port', 'arcl_port')])
def test_a_taken_port_is_named_with_the_way_out(
        argument, other, taken_port, free_port, tmp_path):
    number = taken_port.getsockname()[1]
    result = run(f'{argument}:={number}', f'{other}:={free_port}', folder=tmp_path)
    assert result.returncode == 1
    assert f'TCP port {number} is in use' in result.stdout
    assert f'{argument}:=PORT' in result.stdout


def test_who_has_a_port_is_not_connected_to(taken_port, free_port, tmp_path):
    """A connection to the port of another run would replace the robot of that run."""
    run(f'outgoing_port:={taken_port.getsockname()[1]}', f'arcl_port:={free_port}',
        folder=tmp_path)
    taken_port.setblocking(False)
    with pytest.raises(BlockingIOError):
        taken_port.accept()


def test_an_argument_that_is_none_is_refused(tmp_path):
    result = run('sim_speed=2', folder=tmp_path)
    assert result.returncode == 1
    assert "'sim_speed=2' is not of the form name:=value" in result.stdout


@pytest.mark.parametrize('arguments, problem', [
    ((), 'multimaster:=true needs peer:=ADDRESS'),
    (('peer:=127.0.0.9', 'fleet_manager:=true'), 'fleet_manager:=true would be a second master'),
    (('peer:=127.0.0.9', 'vda5050:=true'), 'vda5050:=true would be a second master'),
    (('peer:=nobody.invalid',), 'there is no network route to peer:=nobody.invalid')])
def test_a_robot_gets_one_master_and_its_ros_master_is_joined_with_somebody(
        arguments, problem, tmp_path, monkeypatch):
    monkeypatch.delenv('ROS_IP', raising=False)
    result = run('multimaster:=true', *arguments, folder=tmp_path)
    assert result.returncode == 1
    assert problem in result.stdout


def test_an_argument_that_no_launch_file_knows_is_refused(tmp_path):
    result = run('map_fle:=x.map', folder=tmp_path)
    assert result.returncode == 1
    assert "no argument 'map_fle'" in result.stdout


def test_files_are_found_from_any_folder_and_in_the_home_folder(tmp_path, monkeypatch):
    monkeypatch.setenv('HOME', str(tmp_path))
    monkeypatch.setenv('ROS_MASTER_URI', 'nowhere')  # so that roslaunch gives up at once
    for name in ('site.map', 'secret'):
        (tmp_path / name).touch()
    result = run('sim:=false', 'map_file:=site.map', 'password_file:=~/secret', folder=tmp_path)
    assert result.returncode != 0
    assert f'map_file:={tmp_path}/site.map' in result.stdout
    assert f'password_file:={tmp_path}/secret' in result.stdout


@pytest.mark.parametrize('argument', ['map_file', 'base_map', 'graph_file', 'password_file'])
def test_a_file_that_is_not_there_is_named(argument, tmp_path):
    result = run(f'{argument}:=site', folder=tmp_path)
    assert result.returncode == 1
    assert f'{argument}:={tmp_path}/site cannot be read' in result.stdout


def test_a_map_that_is_to_be_made_need_not_be_there(tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_MASTER_URI', 'nowhere')  # so that roslaunch gives up at once
    for name in ('base.map', 'graph.yaml'):
        (tmp_path / name).touch()
    result = run('sim:=false', 'map_file:=new.map', 'base_map:=base.map', 'graph_file:=graph.yaml',
                 folder=tmp_path)
    assert f'map_file:={tmp_path}/new.map' in result.stdout
    assert 'cannot be read' not in result.stdout


@pytest.mark.parametrize('port', ['abc', '0', '70000', '-1', ''])
def test_a_port_that_is_none_is_refused(port, tmp_path):
    result = run(f'arcl_port:={port}', folder=tmp_path)
    assert result.returncode == 1
    assert f'arcl_port:={port} is not a TCP port' in result.stdout


def test_help_lists_the_arguments():
    result = run('--help')
    assert result.returncode == 0
    assert 'map_file:=' in result.stdout


@pytest.mark.parametrize('file, is_built', [
    ('src/a/src/b/__init__.py', True), ('src/a/msg/B.msg', True), ('src/a/package.xml', True),
    ('src/a/src/a/module.py', False), ('src/CMakeLists.txt', False)])
def test_the_workspace_is_built_again_where_something_new_has_to_be_found(
        file, is_built, tmp_path):
    for folder in ('launch', 'rviz', 'maps', 'test', 'scripts', 'src/a/nodes'):
        (tmp_path / folder).mkdir(parents=True)
    shutil.copy(ROOT / 'scripts' / 'common.sh', tmp_path / 'scripts')
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    stamp = tmp_path / 'stamp'
    stamp.touch()
    os.utime(stamp, (time.time() + 60.0,) * 2)  # newer than all folders
    (tmp_path / file).touch()
    os.utime(tmp_path / file, (time.time() + 120.0,) * 2)
    newer = subprocess.run(
        ['bash', '-c', f'. {tmp_path}/scripts/common.sh; _newer_than {stamp}'], text=True,
        stdout=subprocess.PIPE, check=True).stdout.split()
    assert newer == ([str(tmp_path / file)] if is_built else [])


def progress_of(tmp_path, output):
    """Begins a command that waits after its first line, and shows its progress on `output`."""
    os.mkfifo(tmp_path / 'go_on')
    command = f'echo Unpacking python3-x; read -r word <{tmp_path}/go_on; exit 3'
    return subprocess.Popen(
        ['bash', '-c', f'. {ROOT}/scripts/common.sh; : >{tmp_path}/log; '
         f'with_progress {tmp_path}/log bash -c "$1" || exit $?', 'bash', command], stdout=output)


def test_the_workspace_is_built_from_any_folder(tmp_path):
    """Without an explicit folder, catkin_make takes the working directory from the variable PWD."""
    for folder in ('scripts', 'src', 'elsewhere'):
        (tmp_path / folder).mkdir()
    shutil.copy(ROOT / 'scripts' / 'common.sh', tmp_path / 'scripts')
    subprocess.run(['bash', '-euc', f'. {tmp_path}/scripts/common.sh; _build; false'],
                   cwd=tmp_path / 'elsewhere', check=False, timeout=120)
    log = (tmp_path / 'build/build.log').read_text()
    assert f'Base path: {tmp_path}\n' in log
    assert f'Source space: {tmp_path}/src\n' in log


def test_a_step_that_takes_its_time_shows_how_far_it_is_on_a_terminal(tmp_path):
    ours, theirs = pty.openpty()
    script = progress_of(tmp_path, theirs)
    os.close(theirs)
    shown = b''
    while b's  Unpacking python3-x' not in shown:
        shown += os.read(ours, 1000)
    (tmp_path / 'go_on').write_text('word\n')
    assert script.wait(20) == 3, 'the exit status is that of the command'
    os.close(ours)
    assert b'\n' not in shown, 'it is one line that changes'
    assert (tmp_path / 'log').read_text() == 'Unpacking python3-x\n'


def test_a_short_step_shows_nothing_where_there_is_no_terminal(tmp_path):
    script = progress_of(tmp_path, subprocess.PIPE)
    (tmp_path / 'go_on').write_text('word\n')
    assert script.communicate(timeout=20)[0] == b'' and script.returncode == 3


@pytest.mark.parametrize('name', ['site_fleet.map', 'site_graph.png'])
def test_new_site_overwrites_no_file_of_the_user(tmp_path, name):
    shutil.copy(ROOT / 'maps' / 'lab_base.map', tmp_path / 'site.map')
    (tmp_path / name).write_text('of the user')
    result = subprocess.run([str(ROOT / 'scripts' / 'new_site.sh'), str(tmp_path / 'site.map'),
                             '--no-start'], text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, timeout=120, check=False)
    assert result.returncode == 1
    assert f'{name} was not made by this script' in result.stdout
    assert (tmp_path / name).read_text() == 'of the user'


@pytest.mark.parametrize('script', sorted(ROOT.glob('scripts/*.sh')), ids=lambda path: path.name)
def test_a_command_that_is_shown_to_people_can_be_copied_with_any_path_in_it(script):
    shown = [line for line in script.read_text().splitlines()
             if re.match(r' *(say|die|echo) ', line) and re.search(r'(roslaunch|rosrun) ', line)]
    for line in shown:
        plain = re.sub(r"\$\(.*printf ' ?%q' .*\)", '', line)
        assert '$' not in plain.replace('$editor', ''), f'{line.strip()}: quote it with %q'


def test_a_namespace_of_the_shell_is_refused_in_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_NAMESPACE', '/hall')
    result = run('rviz:=false', folder=tmp_path)
    assert result.returncode == 1
    assert 'unset ROS_NAMESPACE' in result.stdout


def test_a_computer_without_localhost_is_told_before_anything_is_installed(tmp_path, monkeypatch):
    """A system that debootstrap has made has no localhost."""
    monkeypatch.setenv('BASH_FUNC_getent%%', '() { return 2; }')
    result = run(folder=tmp_path)
    assert result.returncode == 1
    assert "add the line '127.0.0.1 localhost' to /etc/hosts" in result.stdout


def test_a_computer_without_an_address_for_its_own_name_is_told_what_other_terminals_need(
        tmp_path, monkeypatch):
    """A system that debootstrap has made has no such address: `rostopic pub` would not be heard."""
    monkeypatch.setenv('BASH_FUNC_getent%%', '() { [ "$2" = localhost ]; }')
    told = "run 'export ROS_IP=127.0.0.1' there"
    monkeypatch.setenv('ROS_IP', '127.0.0.1')
    assert told not in run('sim_speed=2', folder=tmp_path).stdout
    monkeypatch.delenv('ROS_IP')
    monkeypatch.delenv('ROS_HOSTNAME', raising=False)
    assert told in run('sim_speed=2', folder=tmp_path).stdout


def test_without_a_variable_home_the_home_is_that_of_the_account(tmp_path, monkeypatch):
    monkeypatch.delenv('HOME')
    result = run('sim:=false', 'map_file:=~/no_such.map', folder=tmp_path)
    home = pwd.getpwuid(os.getuid()).pw_dir
    assert f'map_file:={home}/no_such.map cannot be read' in result.stdout


def test_new_site_works_in_an_install_space_too(tmp_path):
    """There, installed_common.sh replaces common.sh, and roslaunch starts the robot."""
    programs = tmp_path / 'lib' / 'ld90_bringup'
    programs.mkdir(parents=True)
    shutil.copy(ROOT / 'scripts' / 'new_site.sh', programs)
    shutil.copy(ROOT / 'src/ld90_bringup/scripts/installed_common.sh', programs / 'common.sh')
    site = tmp_path / "l'atelier 2.map"
    shutil.copy(ROOT / 'maps' / 'lab_base.map', site)
    result = subprocess.run([str(programs / 'new_site.sh'), str(site), '--no-start'], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120,
                            check=False)
    assert result.returncode == 0, result.stdout
    assert 'roslaunch omron_ld90 full_stack.launch map_file:=' in result.stdout
    assert site.with_name("l'atelier 2_fleet.map").exists()


@pytest.mark.parametrize('package', ['omron_ld90', 'ld90_bringup'])
def test_a_package_copied_out_of_the_repository_is_refused_in_a_sentence(tmp_path, package):
    copy = tmp_path / 'src' / package
    shutil.copytree(ROOT / 'src' / package, copy)
    result = subprocess.run(['cmake', '-S', str(copy), '-B', str(tmp_path / 'build')], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120,
                            check=False)
    assert result.returncode != 0
    assert 'put the whole repository into src/' in ' '.join(result.stdout.split())
