"""Run by .peers/ultralytics: prints what Ultralytics finds in a data.yaml: each picture's classes, by split."""

import json
import sys

from ultralytics.data import YOLODataset
from ultralytics.data.utils import check_det_dataset

data = check_det_dataset(sys.argv[1], autodownload=False)
found = {}
for split in ("train", "val", "test"):
    if data.get(split):
        dataset = YOLODataset(img_path=data[split], data=data, task="detect", augment=False, imgsz=160)
        found[split] = {
            label["im_file"].rpartition("/")[2]: [int(k) for k in label["cls"][:, 0]] for label in dataset.labels
        }
print(json.dumps({"names": data["names"], "classes": found}))
