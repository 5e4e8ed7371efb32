import numpy as np
from PIL import Image

from shapemorph.view.frames import write_frames_figure


def test_the_overview_plots_every_frame(tmp_path):
    rows = [
        {
            "frame": f"specimen 7 frame {k:03d}",
            "u_median_px": 0.1 * k,
            "v_median_px": -0.4 * k,
            "E1_median": 0.01 * k,
            "E1_p99": 0.03 * k,
            "E2_median": np.nan if k == 4 else -0.004 * k,
            "zncc_median": 0.99 - 0.001 * k,
            "ok_share": 1 - 0.003 * k,
        }
        for k in range(1, 31)
    ]
    write_frames_figure(rows, tmp_path / "figures")
    with Image.open(tmp_path / "figures" / "frames.png") as image:
        assert image.size[0] > 1200
        assert np.count_nonzero(np.asarray(image.convert("L")) < 200) > 5000
