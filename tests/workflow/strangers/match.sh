#!/usr/bin/env bash
# A matching in shell and jq: the first models with as many doors.
set -euo pipefail
while [ $# -gt 0 ]; do
    case $1 in
        --objects) objects=$2 ;;
        --library) library=$2 ;;
        --out) out=$2 ;;
    esac
    shift
done
jq --slurpfile library "$library" '{version: 1, scene, encoder: "jq", objects: [.objects[] | . as $item |
    if .status != "ok" then {id, label: .label, status, reason} else {id, label: .label, cousins: [
        [$library[0].assets[] | select(.doors == $item.doors)][:4] | to_entries[] |
        {rank: (.key + 1), asset: .value.id, category: .value.category, distance: .key, votes: null,
         orientation: {yaw: 0, distance: 0}, orientations: [{yaw: 0, distance: 0}]}]} end]}' "$objects" >"$out"
