"""`python -m plugins.eyes COMMAND --help`."""

from stages.cli import main

if __name__ == "__main__":
    main(
        "plugins.eyes",
        {
            "see": "find and name the things of a picture with depth",
            "fetch": "download the weights of MobileSAM and SSD, once",
        },
    )
