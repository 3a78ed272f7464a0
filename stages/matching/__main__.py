"""`roomkin matching COMMAND --help`."""

from roomkin.stages.cli import main

main(
    "roomkin.stages.matching",
    {
        "features": "encode the patches of one shard of snapshots",
        "shards": "name the shards that hold the candidates of one picture's objects",
        "match": "rank the cousins of every object of one scene",
        "distances": "how far the library's models look from the cousins of one object",
    },
)
