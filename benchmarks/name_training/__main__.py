"""`python -m benchmarks.name_training learn` and `looks`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "benchmarks.name_training",
        {
            "learn": "shapes in random rooms, and the network that names them",
            "looks": "what CLIP sees in pictures of many models, and the layer that names it",
        },
    )
