#!/usr/bin/env bash
# The steps of docs/results/machines.md in its order, each once a commit; what is pinned there is left. `--list` says what is done.
# results/paper/<step>.txt names the commit that a step was made by, results/paper/<step>.log is what it printed.
set -o pipefail
cd "$(dirname "$0")/../.." || exit
STAMPS=results/paper

# The last commit that changed more than pages (results that are committed make nothing old); nothing where files differ from it.
read_commit() {
    git diff --quiet HEAD -- . ':!docs' ':!*.md' && git log -1 --format=%h -- . ':!docs' ':!*.md'
}

# state STEP: `done` by this commit, `missing`, or the commit that made it.
state() {
    local made
    made=$(cat "$STAMPS/$1.txt" 2>/dev/null) || made=missing
    [[ $made == "$COMMIT" ]] && made=done
    echo "$made"
}

COMMIT=$(read_commit)
export COMMIT
if [[ -z $COMMIT && $1 != --list ]]; then
    echo "error: files differ from the last commit, which the results would name. Fix: git commit, or git stash" >&2
    exit 1
fi
mkdir -p "$STAMPS"
failed=0
while IFS='|' read -r -u 3 _ step pages commits hours command reason _; do
    step=${step//[ \`]/} hours=${hours// /} command=${command#*\`} command=${command%\`*}
    if [[ -z $step ]]; then
        [[ $1 == --list ]] && printf 'pinned: %s by%s:%s\n' "$(grep -oP '(?<=\[)[^]]+' <<<"$pages" | paste -sd,)" "${commits% }" "$reason"
    elif [[ $1 == --list ]]; then
        printf '%-12s %-8s %5s h  %s\n' "$step" "$(state "$step")" "$hours" "$command"
    elif [[ $(state "$step") != done ]]; then
        echo "$step (was: $(state "$step")): $command"
        if bash -c "$command" 2>&1 | tee "$STAMPS/$step.log" && [[ $(read_commit) == "$COMMIT" ]]; then
            echo "$COMMIT" >"$STAMPS/$step.txt"
        else
            failed=1
            echo "error: $step failed, or code changed while it ran; the next steps go on. Fix: $STAMPS/$step.log, then the same command" >&2
        fi
    fi
done 3< <(sed -n '/^| step |/,/^$/p' docs/results/machines.md | tail -n +3 | grep '^|')
exit $failed
