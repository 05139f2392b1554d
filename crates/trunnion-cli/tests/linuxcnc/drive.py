#!/usr/bin/env python3
"""Screen of a LinuxCNC without people: homes the joints, runs one program, samples every servo cycle, ends.

Reads `drive.json` of the folder in which it stands: "program", "start" (MDI lines before it), "seconds" (time limit),
"pins" (read at the end) and "actions" (seconds after the start, name, value). Writes `samples.txt`, one cycle a line, and `result.json`.
"""
import json, os, subprocess, sys, time
import hal, linuxcnc

FOLDER = os.path.dirname(os.path.abspath(__file__))
PLAN = json.load(open(os.path.join(FOLDER, "drive.json")))
ERRORS = (linuxcnc.NML_ERROR, linuxcnc.OPERATOR_ERROR)

command, status, channel = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
result = {"errors": [], "ended": False, "lost": 0}


def listen():
    """Keeps the messages for the operator."""
    while message := channel.poll():
        if message[0] in ERRORS:
            result["errors"].append(message[1].strip())


def wait(condition, what, seconds=20.0):
    """Waits until a condition of the status holds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        status.poll()
        listen()
        if condition():
            return
        time.sleep(0.005)
    raise TimeoutError(what)


def mode(wanted):
    command.mode(wanted)
    command.wait_complete()


def prepare():
    """Switches the machine on, homes it, and enters the lines that stand before the program."""
    wait(lambda: status.axis_mask and status.task_state == linuxcnc.STATE_ESTOP, "the control starts")
    for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
        command.state(state)
        command.wait_complete()
    mode(linuxcnc.MODE_MANUAL)
    command.teleop_enable(0)
    command.wait_complete()
    command.home(-1)
    wait(lambda: all(status.homed[:status.joints]), "all joints are homed")
    mode(linuxcnc.MODE_MDI)
    for line in PLAN["start"]:
        command.mdi(line)
        command.wait_complete(10)
    mode(linuxcnc.MODE_AUTO)


def act(name, value):
    """Does what the operator does while the program runs."""
    if name == "feed":
        command.feedrate(value)
    elif name == "rapid":
        command.rapidrate(value)
    elif name == "pause":
        command.auto(linuxcnc.AUTO_PAUSE)
    elif name == "resume":
        command.auto(linuxcnc.AUTO_RESUME)
    elif name == "step":
        command.auto(linuxcnc.AUTO_STEP)
    elif name == "abort":
        command.abort()
    else:
        raise ValueError(name)


def run():
    """Runs the program to its end, or to the first error."""
    command.program_open(os.path.join(FOLDER, PLAN["program"]))
    command.wait_complete(60)
    status.poll()
    command.auto(linuxcnc.AUTO_RUN, 0)
    wait(lambda: status.interp_state != linuxcnc.INTERP_IDLE or result["errors"], "the program starts")
    begin, actions = time.monotonic(), list(PLAN["actions"])

    def over():
        lines.add(status.motion_line)
        while actions and time.monotonic() - begin >= actions[0][0]:
            _, name, value = actions.pop(0)
            act(name, value)
        idle = status.interp_state == linuxcnc.INTERP_IDLE and status.inpos and not status.queue
        return not actions and (idle or result["errors"])

    lines = set()
    wait(over, "the program ends", PLAN["seconds"])
    result["lines"] = sorted(lines)
    result["ended"] = not result["errors"]
    # After an error the machine comes to a stop first.
    time.sleep(0.5)


def main():
    component = hal.component("drive")
    component.ready()
    prepare()
    with open(os.path.join(FOLDER, "samples.txt"), "w") as samples:
        sampler = subprocess.Popen(["halsampler", "-t"], stdout=samples, stderr=subprocess.DEVNULL)
        hal.set_p("sampler.0.enable", "1")
        try:
            run()
        finally:
            hal.set_p("sampler.0.enable", "0")
            time.sleep(0.3)
            sampler.terminate()
            sampler.wait()
    result["lost"] = int(hal.get_value("sampler.0.overruns"))
    for pin in PLAN["pins"]:
        result[pin] = hal.get_value(pin)


try:
    main()
except (TimeoutError, linuxcnc.error) as failure:
    result["errors"].append(f"{type(failure).__name__}: {failure}")
finally:
    listen()
    with open(os.path.join(FOLDER, "result.json"), "w") as file:
        json.dump(result, file)
sys.exit(0)
