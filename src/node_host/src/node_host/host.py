"""The host: a process with one thread, which makes forks for the `hosted` processes of a launch.

Each connection represents one program from its start to its end. `hosted` sends a request, and then
one byte for each signal to the program. The host sends back the exit status in the form of wait(2).
If a connection ends before its program, `hosted` was killed with SIGKILL, and the host kills the
program.
"""
from __future__ import annotations

import os
import selectors
import signal
import socket
import struct
import sys
import time
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Tuple

import node_program
from node_host import child, shared_memory
from node_host.start_queue import StartQueue
from node_host.start_request import BadRequest, StartRequest, read_request

LARGEST_REQUEST = 1 << 20  # bytes
STREAMS = 3
STATUS = struct.Struct('i')
CREDENTIALS = struct.Struct('3i')  # pid, uid, gid
EXIT_1 = 1 << 8  # exit status 1 in the form of wait(2)
END_WITHIN = 5.0  # s after SIGINT or SIGTERM; then the host kills the programs that still run


@dataclass(eq=False)
class _Program:
    """A connection, and the process of its program after the fork."""

    connection: socket.socket
    request: Optional[StartRequest] = None
    streams: List[int] = field(default_factory=list)
    pid: int = 0
    start_pipe: int = -1  # becomes readable when the program has started


class Host:
    """Serves on a listening socket until a signal ends it."""

    def __init__(self, listener: socket.socket, queue: StartQueue[_Program]) -> None:
        self._listener = listener
        self._queue = queue
        self._programs: List[_Program] = []
        self._selector = selectors.DefaultSelector()
        self._wakeup, self._wakeup_end = socket.socketpair()
        self._ends_at: Optional[float] = None
        for one in (listener, self._wakeup, self._wakeup_end):
            one.setblocking(False)
        self._watch(listener, self._accept)
        self._watch(self._wakeup, self._handle_signals)
        signal.set_wakeup_fd(self._wakeup_end.fileno(), warn_on_full_buffer=False)
        for number in (signal.SIGCHLD, signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: None)

    def serve(self) -> bool:
        """Serves until the end. Returns False in the host, and True in each fork, which must then
        run its program.
        """
        while self._ends_at is None or self._programs:
            for key, _ in self._selector.select(self._patience()):
                if self._selector.get_map().get(key.fd) is key:  # still registered
                    key.data()
            if self._ends_at is not None and time.monotonic() >= self._ends_at:
                for program in self._programs:
                    _send_signal(program, signal.SIGKILL)
            elif self._ends_at is None and self._start_next():
                return True
        return False

    def _patience(self) -> Optional[float]:
        now = time.monotonic()
        if self._ends_at is not None:
            return max(0.1, self._ends_at - now)
        return self._queue.seconds_to_next(now)

    def _watch(self, source: Any, then: Callable[[], None]) -> None:
        self._selector.register(source, selectors.EVENT_READ, then)

    def _accept(self) -> None:
        connection, _ = self._listener.accept()
        _, uid, _ = CREDENTIALS.unpack(connection.getsockopt(
            socket.SOL_SOCKET, socket.SO_PEERCRED, CREDENTIALS.size))
        if uid != os.geteuid():
            connection.close()
            return
        connection.setblocking(False)
        program = _Program(connection)
        self._programs.append(program)
        self._watch(connection, lambda: self._receive(program))

    def _receive(self, program: _Program) -> None:
        try:
            packet, streams = _receive_packet(program.connection)
        except ConnectionError:
            packet, streams = b'', []
        if not packet:
            self._forget_connection(program)
        elif program.request is not None:
            for number in packet:
                self._signal(program, number)
        else:
            self._begin_request(program, packet, streams)

    def _begin_request(self, program: _Program, packet: bytes, streams: List[int]) -> None:
        program.streams = streams
        try:
            request = read_request(packet)
        except BadRequest as error:
            _say(f'A request is refused: {error}')
            self._report(program, EXIT_1)
            return
        if len(streams) != STREAMS:
            _say(f'{request.arguments[0]} comes without its standard streams.')
            self._report(program, EXIT_1)
            return
        program.request = request
        delay = self._queue.ask(program, request.identity, time.monotonic())
        if delay:
            _say(f'{" ".join(request.identity)} ended soon after each of its last starts: it '
                 f'waits for {delay:g} s.')

    def _start_next(self) -> bool:
        """Forks all programs that may start now; returns True in the fork."""
        while True:
            program = self._queue.next(time.monotonic())
            if program is None:
                return False
            if self._fork(program):
                return True

    def _fork(self, program: _Program) -> bool:
        request = program.request
        assert request is not None
        host = os.getpid()
        sys.stdout.flush()
        sys.stderr.flush()
        pipe: Tuple[int, ...] = ()
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, child.ENDS)  # until the fork is ready
        try:
            start_pipe, start_pipe_end = pipe = os.pipe()
            pid = os.fork()
        except OSError as error:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
            for end in pipe:
                os.close(end)
            reason = f'{request.arguments[0]} cannot be started: fork: {error.strerror}.\n'
            _say(reason.rstrip())
            os.write(program.streams[2], reason.encode())
            self._report(program, EXIT_1)
            return False
        if pid == 0:
            child.end_with(host)
            os.close(start_pipe)
            streams = [os.dup(stream) for stream in program.streams]
            self._close()
            child.restore_signals(blocked)
            child.become(request, streams)
            node_program.when_started(shared_memory.give_back)
            node_program.when_started(lambda: os.close(start_pipe_end))
            return True
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        os.close(start_pipe_end)
        program.pid, program.start_pipe = pid, start_pipe
        self._watch(start_pipe, lambda: self._started(program))
        self._close_streams(program)
        return False

    def _started(self, program: _Program) -> None:
        """Notes that the program has closed its end of the pipe, or has ended."""
        if program.start_pipe >= 0:
            self._selector.unregister(program.start_pipe)
            os.close(program.start_pipe)
            program.start_pipe = -1
        self._queue.started(program)

    def _handle_signals(self) -> None:
        for number in self._wakeup.recv(4096):
            if number in (signal.SIGINT, signal.SIGTERM):
                self._end()
        self._reap()

    def _reap(self) -> None:
        by_pid: Dict[int, _Program] = {one.pid: one for one in self._programs if one.pid}
        while by_pid:
            try:
                pid, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                return
            if pid == 0:
                return
            if pid in by_pid:
                self._report(by_pid.pop(pid), status)

    def _end(self) -> None:
        """Ends all programs as Ctrl-C does, and accepts no more connections."""
        if self._ends_at is not None:
            return
        self._ends_at = time.monotonic() + END_WITHIN
        self._selector.unregister(self._listener)
        self._listener.close()
        for program in list(self._programs):
            self._signal(program, signal.SIGINT)

    def _signal(self, program: _Program, number: int) -> None:
        if program.pid:
            _send_signal(program, number)
        else:
            self._report(program, number)  # no fork exists yet: the signal counts as its end

    def _forget_connection(self, program: _Program) -> None:
        if program.pid:
            self._selector.unregister(program.connection)
            _send_signal(program, signal.SIGKILL)
        else:
            self._report(program, EXIT_1)

    def _report(self, program: _Program, status: int) -> None:
        """Reports the end of a program with its status, and removes it."""
        if program not in self._programs:
            return
        self._programs.remove(program)
        self._started(program)
        self._queue.ended(program, status != 0, time.monotonic())
        self._close_streams(program)
        if program.connection in self._selector.get_map():
            self._selector.unregister(program.connection)
            try:
                program.connection.send(STATUS.pack(status))
            except OSError as error:
                _say(f'The end of process {program.pid} cannot be reported: {error.strerror}.')
        program.connection.close()

    def _close_streams(self, program: _Program) -> None:
        for stream in program.streams:
            os.close(stream)
        program.streams = []

    def _close(self) -> None:
        """Closes all that the host has open; each fork calls this."""
        signal.set_wakeup_fd(-1)
        self._selector.close()
        for one in (self._listener, self._wakeup, self._wakeup_end):
            one.close()
        for program in self._programs:
            program.connection.close()
            self._close_streams(program)
            if program.start_pipe >= 0:
                os.close(program.start_pipe)
        self._programs = []


def _receive_packet(connection: socket.socket) -> Tuple[bytes, List[int]]:
    size = struct.calcsize(f'{STREAMS}i')
    packet, control, _, _ = connection.recvmsg(
        LARGEST_REQUEST, socket.CMSG_SPACE(size), socket.MSG_CMSG_CLOEXEC)
    streams: List[int] = []
    for level, kind, content in control:
        if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
            streams += struct.unpack(f'{len(content) // 4}i', content)
    return packet, streams


def _send_signal(program: _Program, number: int) -> None:
    """Sends a signal. The process must still exist, or its status must not have been read yet."""
    os.kill(program.pid, number)


def _say(text: str) -> None:
    print(f'[node_host] {text}', file=sys.stderr, flush=True)
