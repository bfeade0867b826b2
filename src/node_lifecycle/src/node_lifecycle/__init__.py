"""Starts, watches and ends a rospy node.

    from node_lifecycle import parameter, publish_diagnostics, run

    def start():
        port = parameter('~port', 7171, int)
        ...

    run('my_node', start)
"""
from node_lifecycle.diagnostics import publish_diagnostics
from node_lifecycle.log_throttle import warn
from node_lifecycle.parameters import ConfigurationError, choice, number, parameter
from node_lifecycle.startup import init_node, run

__all__ = ['ConfigurationError', 'choice', 'init_node', 'number', 'parameter',
           'publish_diagnostics', 'run', 'warn']
