#!/usr/bin/env python3
"""Screen of a LinuxCNC without people: ends when the task is ready and answers."""
import sys, time
import linuxcnc

status = linuxcnc.stat()
end = time.monotonic() + 60.0
while time.monotonic() < end:
    try:
        status.poll()
    except linuxcnc.error:
        pass  # The channel to the task is not there yet.
    else:
        if status.axis_mask and status.task_state == linuxcnc.STATE_ESTOP:
            print("the task answers", flush=True)
            sys.exit(0)
    time.sleep(0.02)
sys.exit("the task does not answer")
