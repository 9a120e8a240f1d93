"""The ROS master's notices: who publishes what a node has subscribed to."""

import xmlrpc.client
from typing import Dict, Set

ROUNDS = 3
TIMEOUT_S = 5.0


class _Patient(xmlrpc.client.Transport):
    """A node that is stopped does not answer."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


def _addresses(master, names: Set[str]) -> Dict[str, str]:
    """URIs of the nodes that are still there."""
    import rosgraph

    found = {}
    for name in names:
        try:
            found[name] = master.lookupNode(name)
        except rosgraph.MasterException:
            pass
    return found


def tell_subscribers(caller: str) -> None:
    """Tells all subscribers who publishes their topics, as the master does when a publisher comes.

    The master of Ubuntu 20.04 (rosmaster 1.14) now and then fails to send such a notice while it sends another one, and
    rospy may take the answer to its subscription for newer than the notice that followed. The two nodes are then never
    connected. Whoever is connected already is not disturbed.
    @param caller  name of the node that asks
    """
    import rosgraph  # the Python tools work without ROS

    master = rosgraph.Master(caller)
    state = master.getSystemState()
    for _ in range(ROUNDS):
        publishers, subscribers = dict(state[0]), dict(state[1])
        uris = _addresses(master, {name for topics in (publishers, subscribers) for names in topics.values() for name in names})
        silent = set()  # ended or stopped; a publisher of this kind is named all the same: its subscribers stay connected
        for topic, names in subscribers.items():
            known = [uris[name] for name in publishers.get(topic, []) if name in uris]
            for name in names if known else ():
                if name not in uris or name in silent:
                    continue
                try:
                    xmlrpc.client.ServerProxy(uris[name], transport=_Patient()).publisherUpdate("/master", topic, known)
                except (OSError, xmlrpc.client.Error):
                    silent.add(name)
        before, state = state, master.getSystemState()
        if state == before:  # else a newer notice of the master may have come before ours
            return
