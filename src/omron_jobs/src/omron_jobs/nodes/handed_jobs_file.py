"""The file that keeps the jobs of `job_client` across a restart or a power cut."""
from __future__ import annotations

import json
from typing import List, Sequence

from json_records import from_json, to_json
from node_lifecycle import ConfigurationError
from node_lifecycle.kept_files import hold, in_ros_home, replace_json
from omron_jobs.client.handed_jobs import HandedJob


class HandedJobsFile:
    """Keeps jobs; a relative path begins in ROS_HOME."""

    def __init__(self, path: str, parameter: str) -> None:
        """Raises ConfigurationError if another process uses the file."""
        if not path:
            raise ConfigurationError(
                f'Jobs cannot be kept without a file: name one in {parameter}.')
        self._path, self._parameter = in_ros_home(path), parameter
        hold(self._path, parameter)

    def read(self) -> List[HandedJob]:
        """Returns the stored jobs. Raises ConfigurationError if they cannot be read, because a node
        without them would queue jobs twice.
        """
        try:
            with open(self._path, encoding='utf-8') as file:
                return [from_json(HandedJob, record) for record in json.load(file)]
        except FileNotFoundError:
            return []
        except (OSError, ValueError, TypeError, RecursionError) as error:
            raise ConfigurationError(
                f'The jobs in {self._path} cannot be read ({error}): mend the file, or give this '
                f'node another one with {self._parameter}. With another file it does not know its '
                'jobs.') from None

    def write(self, jobs: Sequence[HandedJob]) -> None:
        """Stores all jobs, forced to the disk. Raises OSError."""
        replace_json(self._path, [to_json(job) for job in jobs], on_disk=True)
