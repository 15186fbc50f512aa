"""Draw the pictures of docs/dataset.md from a rendered dataset: its statistics, its contact sheet, its preview page.

Usage: python scripts/dataset_pictures.py [--dataset build/dataset/train] [--out docs/pictures]

Writes dataset-stats.png and dataset-sheet.jpg and, where there is a chromium, dataset-preview.jpg and
dataset-preview-phone.jpg; prints the figures that the page quotes.
"""

import argparse
import shutil
import tempfile
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset import FrameDataset
from adc_bench.dataset.preview import contact_sheet, page_of
from adc_bench.dataset.stats import headline, picture_of, statistics_of

WINDOWS = {"preview": (1280, 900, "light", ""), "preview-phone": (390, 844, "dark", "am")}  # size, scheme, keys pressed
ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"]
SHEET_WIDTH_PX = 1440


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--dataset", default="build/dataset/train", help="the dataset's folder")
    parser.add_argument("--out", type=Path, default=Path("docs/pictures"), help="the folder to write to")
    options = parser.parse_args()
    dataset = FrameDataset(options.dataset)
    options.out.mkdir(parents=True, exist_ok=True)
    found = statistics_of(dataset)
    (options.out / "dataset-stats.png").write_bytes(picture_of(found))
    write_jpeg(options.out / "dataset-sheet.jpg", contact_sheet(dataset, per_camera=2))
    if chromium := shutil.which("chromium"):
        photograph(chromium, page_of(dataset), options.out)
    print(headline(found))


def write_jpeg(path: Path, picture: NDArray[np.uint8]) -> None:
    height = round(picture.shape[0] * SHEET_WIDTH_PX / picture.shape[1])
    small = cv2.resize(picture, (SHEET_WIDTH_PX, height), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(path), cv2.cvtColor(small, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 82])


def photograph(chromium: str, page: bytes, out: Path) -> None:
    """Show the page in windows of several sizes, and save what they show."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "preview.html"
        file.write_bytes(page)
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        for name, (width, height, scheme, keys) in WINDOWS.items():
            window = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
            window.goto(file.as_uri())
            for key in keys:
                window.keyboard.press(key)
            window.screenshot(path=str(out / f"dataset-{name}.jpg"), type="jpeg", quality=80)
        browser.close()


if __name__ == "__main__":
    main()
