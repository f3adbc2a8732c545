"""A Slurm cluster of one node, this machine, in a temporary folder: munged, slurmctld and slurmd with
keys, ports and state of their own, which disturb no other cluster."""

import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol", "setpriv")
PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"


def why_not():
    """Why there can be no cluster here; None where there can."""
    if os.geteuid() != 0:
        return "a cluster needs root"
    missing = [name for name in PROGRAMS if shutil.which(name, path=PATH) is None]
    if missing:
        return "not installed: " + ", ".join(missing)
    try:
        pwd.getpwnam("munge")
    except KeyError:
        return "there is no user munge"
    return None


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def memory_mb():
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2**20


class Cluster:
    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="backsight-slurm-"))
        self.folder.chmod(0o755)
        self.daemons = []
        self.environment = os.environ | {"SLURM_CONF": str(self.folder / "slurm.conf"),
                                         "PATH": PATH}
        try:
            self._start_munge()
            self._start_slurm()
        except BaseException:
            self.stop()
            raise

    def _start(self, name, *arguments):
        with open(self.folder / f"{name}.log", "wb") as log:
            self.daemons.append(subprocess.Popen(arguments, stdout=log, stderr=log,
                                                 env=self.environment, start_new_session=True))

    def _start_munge(self):
        munge = pwd.getpwnam("munge")
        home = self.folder / "munge"
        home.mkdir(mode=0o755)
        os.chown(home, munge.pw_uid, munge.pw_gid)
        key = home / "key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        os.chown(key, munge.pw_uid, munge.pw_gid)
        self.socket = home / "socket"
        self._start("munged", "setpriv", f"--reuid={munge.pw_uid}", f"--regid={munge.pw_gid}",
                    "--clear-groups", "munged", "--foreground", "--force", f"--key-file={key}",
                    f"--socket={self.socket}", f"--pid-file={home}/pid",
                    f"--log-file={home}/log", f"--seed-file={home}/seed")
        self._until(self.socket.exists, "munged did not come up")

    def _start_slurm(self):
        host = socket.gethostname().split(".")[0]
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        (self.folder / "slurm.conf").write_text(f"""
ClusterName=backsight
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={self.socket}
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=2
MinJobAge=600
KillWait=2
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory={memory_mb()} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        self._start("slurmctld", "slurmctld", "-D", "-f", self.environment["SLURM_CONF"])
        self._start("slurmd", "slurmd", "-D", "-f", self.environment["SLURM_CONF"], "-N", host)
        self._until(lambda: "idle" in self.run("sinfo", "--noheader", "--format=%t").stdout,
                    "the node did not come up")

    def _until(self, is_so, complaint, seconds=60):
        end = time.monotonic() + seconds
        while not is_so():
            if time.monotonic() > end:
                logs = "\n".join(f"{log}:\n{log.read_text(errors='replace')[-2000:]}"
                                 for log in sorted(self.folder.rglob("*log")))
                raise RuntimeError(f"{complaint}\n{logs}")
            time.sleep(0.1)

    def run(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True)

    def wait_for_end(self, ids, seconds=1200):
        """Of all these jobs."""
        def ended():
            queue = self.run("squeue", "--noheader", "--format=%i", "--jobs=" + ",".join(ids))
            return queue.returncode == 0 and not queue.stdout.strip()
        self._until(ended, f"the jobs {ids} did not end", seconds)

    def stop(self):
        if any("slurmctld" in daemon.args for daemon in self.daemons):
            self.run("scancel", "--full", "--user=root")
        for daemon in reversed(self.daemons):
            daemon.send_signal(signal.SIGTERM)
        for daemon in self.daemons:
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
