"""Whether a dataset can be learned from, and what it is."""

import hashlib
from collections import Counter

import msgspec

from adc_bench.dataset import FrameDataset
from adc_bench.detector.data import LabelledPictures
from adc_bench.errors import InputError
from adc_bench.world.categories import CATEGORIES


def data_digest(training: LabelledPictures, validation: LabelledPictures) -> str:
    """Return a digest of both sets' labels.

    Raises:
        InputError: a set has no boxes, or no pictures.
    """
    digest = hashlib.sha256()
    for option, source in (("--train", training), ("--val", validation)):
        labels = [tuple(source.annotations(i)) for i in range(len(source))]
        if all(label.ignore for picture in labels for label in picture):
            raise InputError(
                where=f"the dataset of {option}",
                found=f"{len(source)} pictures without a single box",
                wanted="pictures with labelled objects",
                todo="render more frames: adc-bench render --split NAME --out DIR --frames N",
            )
        digest.update(msgspec.json.encode(labels))
    return digest.hexdigest()


def check_classes(dataset: FrameDataset) -> None:
    """Check that a dataset's labels mean what they mean here: counted by our names, they are as many as it says.

    Raises:
        InputError: it names other classes, or ours in another order.
    """
    summary = dataset.manifest.summary
    assert summary is not None, "a FrameDataset is a finished one"
    labels = (label for i in range(len(dataset)) for label in dataset.annotations(i))
    ids = Counter(label.category_id for label in labels if not label.ignore)
    counted = {_name(id_): count for id_, count in ids.items()}
    if counted == summary.boxes:
        return
    differing = sorted(name for name in counted.keys() | summary.boxes.keys() if _differs(name, counted, summary.boxes))
    raise InputError(
        where=dataset.store.path("dataset.toml"),
        found=f"labels of other classes: {', '.join(differing)} are not as many as it says",
        wanted=f"labels of the classes, in this order, {', '.join(CATEGORIES)}",
        todo="render the dataset again with this version",
    )


def _name(category_id: int) -> str:
    return CATEGORIES[category_id - 1] if 0 < category_id <= len(CATEGORIES) else f"class {category_id}"


def _differs(name: str, counted: dict[str, int], said: dict[str, int]) -> bool:
    return counted.get(name, 0) != said.get(name, 0)
