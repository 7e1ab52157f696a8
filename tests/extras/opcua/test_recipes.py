"""Recipes as a PLC reads and chooses them."""

import asyncio

import pytest
from asyncua import Client, ua
from prepared_bench import results_with_recipes
from waiting import PATIENCE

from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.people import Person, Role
from workbench.extras.opcua.admission import OpcUaOptions
from workbench.extras.opcua.methods import METHODS
from workbench.extras.opcua.server import NAMESPACE, OpcUa
from workbench.extras.opcua.values import values_of


@pytest.fixture(scope="module")
def results():
    return results_with_recipes()


@pytest.mark.extensive
def test_a_plc_reads_the_recipes_and_chooses_one_by_number(site):
    server = OpcUa(site.bench, OpcUaOptions(0, Person("plc", Role.OPERATOR)))

    async def choose():
        async with Client(server.url, timeout=PATIENCE) as client:
            space = await client.get_namespace_index(NAMESPACE)
            cell = await client.nodes.objects.get_child(f"{space}:Workbench")
            said = [
                await cell.call_method(
                    f"{space}:ChooseRecipe", ua.Variant(number, ua.VariantType.UInt32)
                )
                for number in (5, 4)
            ]
            recipes = await cell.get_child(f"{space}:Recipes")
            return said, await recipes.read_value()

    try:
        said, recipes = asyncio.run(choose())
    finally:
        server.close()
    assert said == [
        [False, "cell yumi has no recipe 5; it has 4 left, 12 slow"],
        [True, "recipe 4 left is chosen"],
    ]
    assert recipes == "4 left, 12 slow"
    state = site.bench.state
    assert state.cell.recipe == 4
    values = values_of(state, site.bench.live, site.bench.head)
    assert (values["Recipe"], values["Recipes"]) == (4, "4 left, 12 slow")


def test_a_plc_leaves_strategy_and_threshold_to_the_recipe():
    (method,) = (one for one in METHODS if one.name == "MakePlan")
    left, stated = method.make(3, "", -1.0), method.make(3, "auto", 0.2)
    assert isinstance(left, MakePlan) and isinstance(stated, MakePlan)
    assert (left.seed, left.strategy, left.threshold) == (3, "", None)
    assert (stated.strategy, stated.threshold) == ("auto", 0.2)
