"""The process a Python submission lives in: started fresh, it speaks the protocol for an agent or a detector.

`python -m adc_bench.evaluate.child LOAD`; LOAD is JSON. What the submission prints goes to standard output as usual.
"""

import os
import socket
import sys
from pathlib import Path

import cv2
import msgspec

from adc_bench.api import Kind
from adc_bench.evaluate.agent_side import Load
from adc_bench.evaluate.loading import Loaded, asked, fault_of, load_agent
from adc_bench.evaluate.protocol import (
    NOT_AN_ANSWER,
    VERSION,
    Fault,
    Hello,
    MissionMessage,
    ObservationMessage,
    Order,
    Ready,
    answer_message,
)
from adc_bench.evaluate.sensed import observation_in
from adc_bench.evaluate.shelf import ReadShelf
from adc_bench.evaluate.wire import Channel, ClosedError

SOCKET = "ADC_BENCH_SOCKET"
PICTURES = "ADC_BENCH_PICTURES"


def main() -> None:
    """Serve one submission until the other end closes, or a fault is told."""
    cv2.setNumThreads(1)
    end = socket.socket(socket.AF_UNIX)
    end.connect(os.environ[SOCKET])
    channel, folder, load = Channel(end), Path.cwd(), msgspec.json.decode(sys.argv[1], type=Load)
    try:
        agent = load_agent(load, folder)
        channel.send(Hello(protocol=VERSION))
        _serve(channel, load.kind, agent, ReadShelf(Path(os.environ[PICTURES])))
    except ClosedError:
        return
    except Exception as error:  # whatever a submission raises is its own fault, told and scored
        channel.send(fault_of(error, load, folder))


def _serve(channel: Channel, kind: Kind, agent: Loaded, shelf: ReadShelf) -> None:
    while True:
        order: Order = channel.receive(Order)
        if isinstance(order, MissionMessage):
            agent.start(order.mission)
            channel.send(Ready())
        else:
            _step(channel, kind, agent, order, shelf)


def _step(channel: Channel, kind: Kind, agent: Loaded, order: ObservationMessage, shelf: ReadShelf) -> None:
    answer = asked(kind, agent, observation_in(order, shelf))
    try:
        channel.send(answer_message(kind, order.step, answer))
    except TypeError as error:
        channel.send(Fault(kind=NOT_AN_ANSWER[kind], found=str(error)))


if __name__ == "__main__":
    main()
