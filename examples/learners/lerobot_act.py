"""ACT of LeRobot, small enough for a CPU: trained on exported episodes, evaluated by the program.

    ferrule export-episodes episodes --lerobot dataset --relative
    python lerobot_act.py train dataset act
    ferrule evaluate --scene bench --policy "python lerobot_act.py answer act" --policy-hz 20
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np


def train(arguments: argparse.Namespace) -> None:
    import torch
    from lerobot.configs.types import FeatureType
    from lerobot.datasets.lerobot_dataset import LeRobotDataset, LeRobotDatasetMetadata
    from lerobot.datasets.utils import dataset_to_policy_features
    from lerobot.policies.act.configuration_act import ACTConfig
    from lerobot.policies.act.modeling_act import ACTPolicy
    from lerobot.policies.factory import make_pre_post_processors

    torch.set_num_threads(1)  # more only wait for one another: the networks are small
    torch.manual_seed(1)
    name, chunk = "ferrule/insertion", 20
    meta = LeRobotDatasetMetadata(name, root=arguments.data)
    features = dataset_to_policy_features(meta.features)
    outputs = {k: f for k, f in features.items() if f.type is FeatureType.ACTION}
    inputs = {k: f for k, f in features.items() if k.startswith("observation.")}
    config = ACTConfig(
        input_features=inputs, output_features=outputs, device="cpu", chunk_size=chunk,
        n_action_steps=1, temporal_ensemble_coeff=0.01, dim_model=64, n_heads=4, dim_feedforward=256,
        n_encoder_layers=2, n_vae_encoder_layers=1, latent_dim=8, dropout=0.1,
    )
    policy = ACTPolicy(config)
    before, after = make_pre_post_processors(config, dataset_stats=meta.stats)
    steps = {"action": [i / meta.fps for i in range(chunk)]}
    data = LeRobotDataset(name, root=arguments.data, delta_timestamps=steps)
    loader = torch.utils.data.DataLoader(data, batch_size=64, shuffle=True, drop_last=True)
    optimizer = torch.optim.AdamW(policy.get_optim_params(), lr=3e-4, weight_decay=1e-4)
    policy.train()
    begin, step = time.process_time(), 0
    while step < arguments.steps:
        for batch in loader:
            loss, _ = policy.forward(before(batch))
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            if step % 200 == 0:
                print(f"step {step}: loss {loss.item():.4f}", file=sys.stderr)
            step += 1
            if step == arguments.steps:
                break
    print(f"trained in {time.process_time() - begin:.0f} s of one processor")
    policy.save_pretrained(arguments.folder)
    before.save_pretrained(arguments.folder)
    after.save_pretrained(arguments.folder)
    environment = json.loads((Path(arguments.data) / "meta/info.json").read_text())["environment"]
    (Path(arguments.folder) / "environment.json").write_text(json.dumps(environment["kwargs"]))


def answer(arguments: argparse.Namespace) -> None:
    """Observations on stdin, velocities on stdout, a line each."""
    out, sys.stdout = sys.stdout, sys.stderr
    import torch
    from lerobot.policies.act.modeling_act import ACTPolicy
    from lerobot.policies.factory import make_pre_post_processors

    from ferrule.policy_program import answer as answer_program

    torch.set_num_threads(1)
    policy = ACTPolicy.from_pretrained(arguments.folder)
    before, after = make_pre_post_processors(policy.config, pretrained_path=arguments.folder)

    def act(observation: np.ndarray) -> np.ndarray:
        state = torch.from_numpy(observation)
        observed = {"observation.state": state, "observation.environment_state": state[:5]}
        return after(policy.select_action(before(observed))).squeeze(0).numpy()

    environment = json.loads((Path(arguments.folder) / "environment.json").read_text())
    answer_program(environment, act, policy.reset, out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    verbs = parser.add_subparsers(required=True)
    verb = verbs.add_parser("train")
    verb.add_argument("data")
    verb.add_argument("folder")
    verb.add_argument("--steps", type=int, default=3000)
    verb.set_defaults(run=train)
    verb = verbs.add_parser("answer")
    verb.add_argument("folder")
    verb.set_defaults(run=answer)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
