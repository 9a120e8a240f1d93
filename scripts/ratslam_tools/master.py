"""The ROS master's notices: who publishes what a node has subscribed to."""

import xmlrpc.client

ROUNDS = 3
TIMEOUT_S = 5.0


class _Patient(xmlrpc.client.Transport):
    """A node that is stopped does not answer."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


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
        uris = {}
        for topic, subscribers in state[1]:
            publishers = dict(state[0]).get(topic, [])
            for node in {*publishers, *subscribers} - set(uris):
                try:
                    uris[node] = master.lookupNode(node)
                except rosgraph.MasterException:  # it has just ended
                    uris[node] = None
            known = [uris[node] for node in publishers if uris[node]]
            for node in subscribers if known else ():
                if not uris[node]:
                    continue
                try:
                    xmlrpc.client.ServerProxy(uris[node], transport=_Patient()).publisherUpdate("/master", topic, known)
                except (OSError, xmlrpc.client.Error):
                    uris[node] = None  # it has ended, or is stopped
        before, state = state, master.getSystemState()
        if state == before:  # else a newer notice of the master may have come before ours
            return
