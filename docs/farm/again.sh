# Sourced by the scripts beside it: again COMMAND... runs the command; where it fails or is killed, the scheduler gets the
# task back, three times at most.
again() {
  local status=0
  "$@" || status=$?
  [ "$status" -ne 0 ] || return 0
  if [ "${SLURM_RESTART_COUNT:-0}" -lt 3 ]; then
    echo "exit status $status: task $SLURM_ARRAY_TASK_ID goes back to the queue" >&2
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
    sleep 60  # until the scheduler ends this run
  fi
  return "$status"
}
