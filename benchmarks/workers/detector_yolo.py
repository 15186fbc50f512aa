"""The peers' turns. usage: detector_yolo.py graph FILE.onnx THREADS | train MODEL THREADS BATCH

`graph` is the network alone: no decoding, no suppression. `train` runs under .peers/ultralytics.
"""

import sys

import numpy as np
from turns import serve


def graph(path: str, threads: int) -> None:
    import onnxruntime as ort

    options = ort.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
    session = ort.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    x = np.random.default_rng(0).random((1, 3, 256, 320), dtype=np.float32)
    name = session.get_inputs()[0].name
    session.run(None, {name: x})
    serve(lambda: session.run(None, {name: x}))


def train(model: str, threads: int, batch: int) -> None:
    import torch
    from ultralytics.cfg import get_cfg
    from ultralytics.nn.tasks import DetectionModel

    torch.set_num_threads(threads)
    network = DetectionModel(f"{model}.yaml", nc=21, verbose=False).train()
    network.args = get_cfg()
    optimizer = torch.optim.SGD(network.parameters(), lr=0.01, momentum=0.9)
    shown = {
        "img": torch.rand(batch, 3, 320, 320),
        "batch_idx": torch.arange(batch).repeat_interleave(2).float(),
        "cls": torch.tensor([[0.0], [1.0]]).repeat(batch, 1),
        "bboxes": torch.tensor([[0.37, 0.6, 0.5, 0.2], [0.69, 0.25, 0.125, 0.1]]).repeat(batch, 1),
    }

    def step() -> None:
        loss = network(shown)[0].sum()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    step()
    serve(step)


if __name__ == "__main__":
    if sys.argv[1] == "graph":
        graph(sys.argv[2], int(sys.argv[3]))
    else:
        train(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
