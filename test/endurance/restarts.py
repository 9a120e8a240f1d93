#!/usr/bin/python3
"""Kills each node, and all at once, at several moments of a drive through the town, starts them again, and prints what that did
to the map: mean APE of the final trajectory beside that of the undisturbed run, the way driven meanwhile, how much of what was
known was lost, places mistaken for others. Exits with 1 where a place was mistaken, where the error exceeds 1.2 times the
undisturbed one by more than the way driven meanwhile, or where more than autosave_period (SIGTERM: 0.1 s) was lost."""
import argparse
import os
import signal
import socket
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "integration"))

MAP_NODES = ("ratslam_lv", "ratslam_pc", "ratslam_em")
AUTOSAVE_S = 5.0
#         odometry, nodes, whether with checkpoints, by which signal
CASES = [("external", [name], kept, signal.SIGKILL) for name in MAP_NODES for kept in (True, False)] + [
    ("external", list(MAP_NODES), True, signal.SIGKILL),
    ("external", list(MAP_NODES), True, signal.SIGTERM),
    ("profile", ["ratslam_vo"], True, signal.SIGKILL),
    ("orb", ["ratslam_orb_vo"], True, signal.SIGKILL)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, nargs="+", default=[120, 250, 310, 450], help="frames at which nodes are killed")
    parser.add_argument("--dead", type=int, default=30, help="frames until they are started again")
    parser.add_argument("--nodes", nargs="+", help="only the cases in which these are killed")
    parser.add_argument("--belief", action="store_true", help="recalls by belief: the local view listens to the odometry")
    options = parser.parse_args()
    with socket.socket() as found:
        found.bind(("", 0))
        port = found.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost", ROS_HOME=folder, ROS_LOG_DIR=folder)
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            failed = run(options, folder)
        finally:
            master.kill()
            master.wait()
    os._exit(1 if failed else 0)  # rospy's threads outlive the master


def run(options, folder):
    """@return how many trials went wrong"""
    import harness
    import restart_trials as trials
    import rosgraph
    import rospy
    if not harness.wait_until(rosgraph.is_master_online, 30.0):
        raise SystemExit("the master did not start")
    rospy.init_node("restarts", disable_signals=True)
    if options.belief:
        trials.CONFIG.update({"vt_descriptor": "orientation", "vt_recall": "belief"})
    bag = os.path.join(folder, "town.bag")
    harness.write_town(bag, *trials.TOWN)
    town = trials.Town(bag)
    undisturbed, failed, number = {}, 0, 0
    print("| killed | by | checkpoints | at frame | driven meanwhile [m] | lost [s] | error [m] | undisturbed | recalls, false |\n"
          "|---|---|---|---|---|---|---|---|---|")
    for odometry, nodes, checkpoints, by in CASES:
        if options.nodes and not set(options.nodes) & set(nodes):
            continue
        if odometry not in undisturbed:
            undisturbed[odometry] = trials.undisturbed(town, os.path.join(folder, odometry), odometry)[0]
        for moment in options.moments:
            number += 1
            kept = {"map_dir": f"{folder}/map{number}", "autosave_period": AUTOSAVE_S} if checkpoints else {}
            chain = trials.Chain(town, f"/trial{number}", f"{folder}/trial{number}", odometry, **kept)
            rate = 30.0 if odometry == "orb" else 100.0
            # Played faster than driven, a checkpoint would have less time to be written.
            since_checkpoint = (town.stamps[moment - 1] - town.stamps[0]).to_sec() % AUTOSAVE_S
            chain.restart(nodes, moment, moment + options.dead, rate, by, since_checkpoint)
            chain.drive(len(town.frames), rate)
            chain.finish()
            error = town.error(chain.trajectory + "_final.tum", odometry != "external")[0]
            (recalled, wrong), (_, wrong_decisions) = chain.false_recalls()
            way = town.way(moment, moment + options.dead)
            lost = max(chain.forgotten(name, moment) for name in nodes) if checkpoints else None
            failed += (wrong + wrong_decisions > 0 or error > 1.2 * undisturbed[odometry] + way
                       or (lost or 0.0) > (0.1 if by == signal.SIGTERM else AUTOSAVE_S))
            print(f"| {' '.join(nodes)} | {by.name} | {'5 s' if checkpoints else 'none'} | {moment} | {way:.1f} | "
                  f"{'all' if lost is None else f'{lost:.1f}'} | {error:.2f} | {undisturbed[odometry]:.2f} | "
                  f"{recalled}, {wrong + wrong_decisions} |", flush=True)
    return failed


if __name__ == "__main__":
    main()
