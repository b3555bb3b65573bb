"""Field of Sionna RT across the boundaries of one corner's rays, where the sum of all rays has to be continuous.

    python boundary.py [--material metal]

A square house with one corner at the origin; transmitter at (20, -20), so that one of the corner's two faces is lit;
receivers 20 m from the corner, a hundredth of a degree and more on either side of the boundary of the reflected and of the direct ray.
Amplitudes are relative to free space over the way past the corner. On a boundary, both sides should come to 0.5 (UTD).
"""

import argparse
import tempfile

import numpy as np
import shapely

import extrusion
from beside_sionna import FREQUENCY_HZ, HEIGHT_M, LIGHT_M_S, SAME_HEIGHT_M, TERMINAL_M

TX_M, DISTANCE_M = (20.0, -20.0), 20.0
OFFSETS_DEG = [-1, -0.1, -0.01, 0.01, 0.1, 1]
BOUNDARIES_DEG = {"reflected": (-135.0, 1), "direct": (135.0, 0)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--material", choices=["metal", "concrete"], default="metal")
    args = parser.parse_args()
    import sionna.rt

    house = shapely.Polygon([(0, 0), (40, 0), (40, 40), (0, 40)])
    with tempfile.TemporaryDirectory() as folder:
        file = extrusion.write_scene(folder, [house], HEIGHT_M, True, args.material, 10.0)
        scene = sionna.rt.load_scene(str(file))
    scene.frequency = FREQUENCY_HZ
    scene.tx_array = scene.rx_array = sionna.rt.PlanarArray(num_rows=1, num_cols=1, pattern="iso", polarization="V")
    scene.add(sionna.rt.Transmitter("tx", [*TX_M, TERMINAL_M]))
    azimuths = [(boundary, offset) for boundary in BOUNDARIES_DEG for offset in OFFSETS_DEG]
    for r, (boundary, offset) in enumerate(azimuths):
        azimuth = np.radians(BOUNDARIES_DEG[boundary][0] + offset)
        scene.add(sionna.rt.Receiver(f"rx{r}", [*map(float, DISTANCE_M * np.array([np.cos(azimuth), np.sin(azimuth)])), TERMINAL_M]))
    paths = sionna.rt.PathSolver(deterministic=True)(
        scene, max_depth=1, samples_per_src=100_000, max_num_paths_per_src=10_000, refraction=False, diffraction=True
    )
    valid, kinds = paths.valid.numpy()[:, 0], paths.interactions.numpy()[0, :, 0]
    points = paths.vertices.numpy()[0, :, 0]
    gains = (paths.a[0].numpy() + 1j * paths.a[1].numpy())[:, 0, 0, 0]
    free = LIGHT_M_S / FREQUENCY_HZ / (4 * np.pi * (np.hypot(*TX_M) + DISTANCE_M))
    at_corner = np.linalg.norm(points - [0, 0, TERMINAL_M], axis=-1) < 10 * SAME_HEIGHT_M
    print("| boundary of the | degrees from it | ray | diffracted | abs(sum) |\n|---|---|---|---|---|")
    for r, (boundary, offset) in enumerate(azimuths):
        ray = gains[r][valid[r] & (kinds[r] == BOUNDARIES_DEG[boundary][1])].sum() / free
        bent = gains[r][valid[r] & (kinds[r] == 8) & at_corner[r]].sum() / free
        print(f"| {boundary} ray | {offset} | {ray:.3f} | {bent:.3f} | {abs(ray + bent):.3f} |")


if __name__ == "__main__":
    main()
