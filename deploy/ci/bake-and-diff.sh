#!/usr/bin/env bash
# Has a server bake a scene as it is and as it was, and compares the two.
#
#   HOODOO_URL=https://hoodoo.example HOODOO_KEY=... bake-and-diff.sh NEW.json OLD.json FOLDER
#
# FOLDER gets report.json and diff.html. Ends with 0 where both tilesets are the same, 1 where they differ, 2 on errors.
# The server compares them by its process diff-tilesets, which answers what `hoodoo diff --json --html FILE` prints and writes.
# Needs curl and jq. A scene that was baked well before is not baked again: its job is found by the scene's digest.
set -euo pipefail
if [ $# -ne 3 ]; then
  sed -n 's/^# \{0,1\}//; 2,8p' "$0" >&2
  exit 2
fi
new=$1 old=$2 folder=$3
url=${HOODOO_URL:?the address of the server}
trap 'if [ $? -gt 1 ]; then exit 2; fi' EXIT

ask() {
  curl --silent --show-error --fail-with-body --retry 3 \
    ${HOODOO_KEY:+--header "Authorization: Bearer $HOODOO_KEY"} "$@"
}

# The id of the job that carries out process $1 on the inputs on standard input.
begin() {
  local request answer
  request=$(jq --compact-output '{inputs: .}')
  answer=$(ask --header 'Content-Type: application/json' --header 'Prefer: respond-async' \
    --header "Idempotency-Key: $(sha256sum <<< "$1 $request" | cut -c1-64)" \
    --data-binary @- "$url/processes/$1/execution" <<< "$request") || { echo "$answer" >&2; return 2; }
  jq --raw-output .jobID <<< "$answer"
}

# Waits for the end of job $1.
await() {
  local state
  while :; do
    state=$(ask --header 'Prefer: wait=30' "$url/jobs/$1")
    case $(jq --raw-output .status <<< "$state") in
      successful) return ;;
      accepted | running) ;;
      *) echo "$state" >&2; return 2 ;;
    esac
  done
}

mkdir -p "$folder"
first=$(jq '{scene: .}' "$old" | begin bake-terrain)
second=$(jq '{scene: .}' "$new" | begin bake-terrain)
await "$first"
await "$second"
compared=$(jq --null-input --arg first "$first" --arg second "$second" '{$first, $second}' | begin diff-tilesets)
await "$compared"
results=$(ask "$url/jobs/$compared/results")
ask --output "$folder/report.json" "$(jq --raw-output .report.href <<< "$results")"
ask --output "$folder/diff.html" "$(jq --raw-output .page.href <<< "$results")"
if [ "$(jq .same "$folder/report.json")" = true ]; then
  echo "The tilesets are the same."
else
  echo "The tilesets differ: see $folder/diff.html"
  exit 1
fi
