# SPDX-License-Identifier: Apache-2.0
"""A program of a user, held to the types of the package by stubs_test.py; it is not run."""
from typing import Optional

import numpy as np
import sarblock
from numpy.typing import NDArray


def worst_point(result: sarblock.Result) -> tuple[str, float]:
    """The point whose height is known worst."""
    sigma_m: NDArray[np.float64] = result.points.sigma_enu_m[:, 2]
    index = int(np.nanargmax(sigma_m))
    return str(result.points.ids[index]), float(sigma_m[index])


def tell(stage: str, done: int, total: int, detail: str) -> None:
    print(stage, done, total, detail)


def main() -> Optional[str]:
    block = sarblock.simulate("scene.toml", points={"count": 50})
    try:
        result = sarblock.adjust(block, robust="huber", progress=tell, threads=2)
    except sarblock.UndeterminedError as error:
        return ", ".join(error.names)
    except sarblock.Interrupted:
        return None
    block.write("block.h5")
    result.write("result", gzip=True)
    covariance: NDArray[np.float64] = result.points.covariance_enu_m2
    noise = sarblock.leberl.noise_of_range(7000.0, 9000.0, np.linspace(12e3, 20e3, 5), 0.5)
    print(worst_point(result), covariance.shape, noise.sigma_z_m, block.passes[0].states[0, 0])
    for option in sarblock.option_table():
        print(option.key, option.allowed)
    return None


if __name__ == "__main__":
    main()
