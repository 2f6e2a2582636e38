"""BC-RNN of robomimic, unmodified: trained on exported episodes, evaluated by the program.

    ferrule export-episodes episodes --robomimic all.h5 --relative
    python robomimic_bc_rnn.py train all.h5 bc-rnn
    ferrule evaluate --scene bench --policy "python robomimic_bc_rnn.py answer bc-rnn" --policy-hz 20
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np


def configuration(data: str, folder: str, epochs: int, rollouts: int):
    from robomimic.config import config_factory

    config = config_factory("bc")
    with config.values_unlocked():
        config.experiment.name = "bc-rnn"
        config.experiment.validate = True
        config.experiment.logging.log_tb = False
        config.experiment.logging.log_wandb = False
        config.experiment.save.every_n_epochs = epochs
        config.experiment.save.on_best_validation = True
        config.experiment.save.on_best_rollout_success_rate = False
        config.experiment.epoch_every_n_steps = 100
        config.experiment.validation_epoch_every_n_steps = 10
        config.experiment.rollout.enabled = rollouts > 0
        config.experiment.rollout.n = rollouts
        config.experiment.rollout.horizon = 1300  # 60 s at 20 Hz, and a little
        config.experiment.rollout.rate = epochs
        config.experiment.render_video = False
        config.train.data = str(Path(data).absolute())
        config.train.output_dir = str(Path(folder).absolute())
        config.train.num_data_workers = 0
        config.train.hdf5_cache_mode = "all"
        config.train.hdf5_filter_key = "train"
        config.train.hdf5_validation_filter_key = "valid"
        config.train.num_epochs = epochs
        config.train.batch_size = 64
        config.train.seq_length = 10
        config.train.cuda = False
        config.observation.modalities.obs.low_dim = ["flat"]
        config.algo.actor_layer_dims = ()
        config.algo.rnn.enabled = True
        config.algo.rnn.horizon = 10
        config.algo.rnn.hidden_dim = 64
        config.algo.rnn.num_layers = 2
    return config


def train(arguments: argparse.Namespace) -> None:
    import torch
    from robomimic.scripts.train import train as run

    torch.set_num_threads(1)  # more only wait for one another: the networks are small

    config = configuration(arguments.data, arguments.folder, arguments.epochs, arguments.rollouts)
    config.lock()
    begin = time.process_time()
    run(config, device="cpu")
    print(f"trained in {time.process_time() - begin:.0f} s of one processor, with rollouts")


def answer(arguments: argparse.Namespace) -> None:
    """Observations on stdin, velocities on stdout, a line each."""
    out, sys.stdout = sys.stdout, sys.stderr  # robomimic prints
    import robomimic.utils.file_utils as files
    import torch

    from ferrule.policy_program import answer as answer_program

    torch.set_num_threads(1)
    newest = max(Path(arguments.folder).rglob("*.pth"), key=lambda file: file.stat().st_mtime)
    policy, checkpoint = files.policy_from_checkpoint(ckpt_path=str(newest), device="cpu")
    environment = dict(checkpoint["env_metadata"]["env_kwargs"])
    environment.pop("seed")

    def act(observation: np.ndarray) -> np.ndarray:
        return policy(ob={"flat": observation})

    answer_program(environment, act, policy.start_episode, out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    verbs = parser.add_subparsers(required=True)
    verb = verbs.add_parser("train")
    verb.add_argument("data")
    verb.add_argument("folder")
    verb.add_argument("--epochs", type=int, default=100)
    verb.add_argument("--rollouts", type=int, default=5)
    verb.set_defaults(run=train)
    verb = verbs.add_parser("answer")
    verb.add_argument("folder")
    verb.set_defaults(run=answer)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
