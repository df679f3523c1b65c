"""Topics of a world in this process, as tests hear them and publish on them."""

from libgz.classic import transport


def _node(space):
    node = transport.Node()
    node.Init(space)
    return node


class Heard(list):
    """The messages of a topic."""

    def __init__(self, topic, space="default", latching=False):
        super().__init__()
        self.node = _node(space)
        self.subscriber = self.node.Subscribe(topic, self.append, latching)


def send(topic, message, space="default"):
    """Publish one message; the topic ends with the publisher that is returned."""
    publisher = _node(space).Advertise(type(message), topic)
    publisher.Publish(message)
    return publisher
