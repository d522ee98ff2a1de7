#!/usr/bin/env bash
# Fuzzes every target, or those named, with as many executions each as RUNS says (10 million), for at most SECONDS each.
# Prints the rows of the README's table. What is found is kept in artifacts/, what was reached in corpus/.
set -euo pipefail
cd "$(dirname "$0")"

runs=${RUNS:-10000000}
seconds=${SECONDS_EACH:-0}
target_dir=${CARGO_TARGET_DIR:-target}
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(well model system csv mcap mat5 mat73)

# No address sanitizer: the readers have no unsafe code, and the vendored C of zstd and lz4 is not instrumented by it.
# Memory is counted by the targets' own allocator.
[ -n "${BUILT:-}" ] || cargo +nightly fuzz build --fuzz-dir . -s none --target-dir "$target_dir"
echo "| target | executions | per second of one core | peak memory, MB | edges | features | corpus | findings |"
echo "| --- | --- | --- | --- | --- | --- | --- | --- |"
for target in "${targets[@]}"; do
    fixtures=()
    case $target in
        mat5 | mat73) longest=20480 fixtures=(../dgd-ingest/tests/data/mat) ;;
        mcap) longest=4096 fixtures=(../dgd-ingest/tests/data/mcap) ;;
        *) longest=2048 ;;
    esac
    mkdir -p "corpus/$target" "artifacts/$target" logs
    times=logs/$target.time
    TIMEFORMAT='%U %S'
    { time "$target_dir/x86_64-unknown-linux-gnu/release/$target" -runs="$runs" -max_total_time="$seconds" -max_len=$longest \
        -rss_limit_mb=2048 -malloc_limit_mb=1024 -timeout=10 -dict="dictionaries/$target.dict" -print_final_stats=1 \
        -artifact_prefix="artifacts/$target/" "corpus/$target" "seeds/$target" "${fixtures[@]}" \
        2>"logs/$target.log" || true; } 2>"$times"
    done_=$(sed -n 's/^stat::number_of_executed_units: *//p' "logs/$target.log")
    rss=$(sed -n 's/^stat::peak_rss_mb: *//p' "logs/$target.log")
    last=$(grep -a ' cov: ' "logs/$target.log" | tail -n 1)
    field() { sed -n "s/.* $1: \([^ ]*\).*/\1/p" <<<"$last"; }
    found=$(find "artifacts/$target" -type f | wc -l)
    rate=$(awk -v n="${done_:-0}" '{ printf "%.0f", n / ($1 + $2) }' "$times")
    echo "| \`$target\` | ${done_:-0} | $rate | ${rss:-?} | $(field cov) | $(field ft) | $(field corp) | $found |"
done
