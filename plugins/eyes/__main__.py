"""`python -m plugins.eyes fetch`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.eyes", {"fetch": "download the weights of MobileSAM and SSD, once"})
