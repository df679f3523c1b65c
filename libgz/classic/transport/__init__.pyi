"""The public names of libgz.classic.transport, and the one module that each comes from."""

from libgz.classic.transport.address import get_master_uri as get_master_uri, publicized_address as publicized_address
from libgz.classic.transport.functions import (
    clear_buffers as clear_buffers,
    fini as fini,
    get_topic_namespaces as get_topic_namespaces,
    getAdvertisedTopics as getAdvertisedTopics,
    getTopicMsgType as getTopicMsgType,
    init as init,
    is_stopped as is_stopped,
    pause_incoming as pause_incoming,
    request as request,
    requestNoReply as requestNoReply,
    run as run,
    stop as stop,
)
from libgz.classic.transport.link import Link as Link, connect as connect, serve as serve
from libgz.classic.transport.manager import TopicManager as TopicManager
from libgz.classic.transport.node import Node as Node
from libgz.classic.transport.publisher import Publisher as Publisher
from libgz.classic.transport.subscriber import Subscriber as Subscriber
