"""The recipe of Zhao 2023 in Keras, for a Python that has TensorFlow: a cross-check, no more.

Run by benchmarks/costs/training.py --keras PYTHON with the samples it prepared; 17 minutes of CPU.
usage: python training_keras.py SAMPLES.npz EPOCHS RESULT.json
"""

from __future__ import annotations

import json
import os
import sys
import time

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import keras
import numpy as np

SEED = 0
LOOK_EVERY = 100


def main(samples: str, epochs: int, result: str) -> None:
    """Train and write error and times."""
    data = np.load(samples)
    x, y, held_x, held_y = (data[name].astype("float32") for name in ("x", "y", "xv", "yv"))
    keras.utils.set_random_seed(SEED)
    hidden = [keras.layers.Dense(50, activation="sigmoid") for _ in range(8)]
    model = keras.Sequential([keras.Input((3,)), *hidden, keras.layers.Dense(3)])
    model.compile(optimizer="adam", loss="mse")
    wall_s, cpu_s = time.monotonic(), time.process_time()
    for done in range(0, epochs, LOOK_EVERY):
        count = min(LOOK_EVERY, epochs - done)
        model.fit(x, y, batch_size=32, epochs=count, verbose=0)
        error_deg = (model(held_x).numpy() - held_y) * data["deviation_deg"]
        found = {
            "data": str(data["digest"]),
            "epochs": done + count,
            "rmse_deg": float(np.sqrt(np.mean(error_deg**2))),
            "wall_s": time.monotonic() - wall_s,
            "cpu_s": time.process_time() - cpu_s,
            "keras": keras.__version__,
        }
        with open(result, "w") as stream:
            json.dump(found, stream)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
