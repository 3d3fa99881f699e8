#!/usr/bin/env python3
"""Principal curvatures: carreau beside libigl's principal_curvature on the same meshes; see README.md."""
from common import arguments, beside_libigl


def main():
    beside_libigl(arguments(__doc__), {
        "carreau corrected": ["curvature"],
        "carreau ball": ["curvature", "--estimator", "normal-cycle-ball"],
    })


if __name__ == "__main__":
    main()
