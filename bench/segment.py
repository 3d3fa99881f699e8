#!/usr/bin/env python3
"""Segmentation: the whole of carreau segment beside libigl's curvature alone on the same meshes; see README.md."""
from common import arguments, beside_libigl


def main():
    beside_libigl(arguments(__doc__), {"carreau curvature": ["curvature"], "carreau segment": ["segment"]})


if __name__ == "__main__":
    main()
