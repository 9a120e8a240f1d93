#!/usr/bin/python3
"""Kills each node, and all at once, at several moments of a drive through the town, starts them again, and prints what that did
to the map: mean APE of the final trajectory beside that of the undisturbed run, the way driven meanwhile, places mistaken for
others. Exits with 1 where a place was mistaken, or the error exceeds 1.2 times the undisturbed one (an odometry of ours: twice)
by more than the way driven meanwhile."""
import argparse
import os
import socket
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "integration"))

MAP_NODES = ("ratslam_lv", "ratslam_pc", "ratslam_em")
#         odometry, nodes, whether without checkpoints as well
CASES = [("external", [name], True) for name in MAP_NODES] + [
    ("external", list(MAP_NODES), False), ("profile", ["ratslam_vo"], False), ("orb", ["ratslam_orb_vo"], False)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, nargs="+", default=[120, 250, 310, 450], help="frames at which nodes are killed")
    parser.add_argument("--dead", type=int, default=30, help="frames until they are started again")
    parser.add_argument("--nodes", nargs="+", help="only the cases in which these are killed")
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
    bag = os.path.join(folder, "town.bag")
    subprocess.run([harness.executable("ratslam_town"), "--out", bag, *trials.TOWN], check=True, stdout=subprocess.DEVNULL)
    town = trials.Town(bag)
    undisturbed, failed, number = {}, 0, 0
    print("| killed | checkpoints | at frame | driven meanwhile [m] | error [m] | undisturbed | recalls, false |\n|---|---|---|---|---|---|---|")
    for odometry, nodes, without in CASES:
        if options.nodes and not set(options.nodes) & set(nodes):
            continue
        if odometry not in undisturbed:
            undisturbed[odometry] = trials.undisturbed(town, os.path.join(folder, odometry), odometry)[0]
        for checkpoints in (True, False) if without else (True,):
            for moment in options.moments:
                number += 1
                kept = {"map_dir": f"{folder}/map{number}", "autosave_period": 5.0} if checkpoints else {}
                chain = trials.Chain(town, f"/trial{number}", f"{folder}/trial{number}", odometry, **kept)
                rate = 30.0 if odometry == "orb" else 100.0
                chain.restart(nodes, moment, moment + options.dead, rate)
                chain.drive(len(town.frames), rate)
                chain.finish()
                error = town.error(chain.trajectory + "_final.tum", odometry != "external")[0]
                (recalled, wrong), (_, wrong_decisions) = chain.false_recalls()
                way = town.way(moment, moment + options.dead)
                most = (1.2 if odometry == "external" else 2.0) * undisturbed[odometry] + way
                failed += wrong + wrong_decisions > 0 or error > most
                print(f"| {' '.join(nodes)} | {'5 s' if checkpoints else 'none'} | {moment} | {way:.1f} | {error:.2f} | "
                      f"{undisturbed[odometry]:.2f} | {recalled}, {wrong + wrong_decisions} |", flush=True)
    return failed


if __name__ == "__main__":
    main()
