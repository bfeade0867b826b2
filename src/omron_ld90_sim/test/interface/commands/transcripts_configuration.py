"""Transcripts: reading and changing the configuration (form as in `transcripts_state`)."""
from __future__ import annotations

IMMEDIATE = {
    'getConfigSectionList': [['getConfigSectionList'], [
        'GetConfigSectionList: ARCL server setup',
        'GetConfigSectionList: Outgoing ARCL connection setup',
        'GetConfigSectionList: Outgoing ARCL commands', 'GetConfigSectionList: Files',
        'GetConfigSectionList: Docking', 'GetConfigSectionList: Enterprise Manager Connection',
        'EndOfGetConfigSectionList']],
    'getConfigSectionValues': [['getConfigSectionValues Docking', 'getConfigSectionValues Files',
                                'getConfigSectionValues docking'],
                               ['GetConfigSectionValue: AutoDock false',
                                'GetConfigSectionValue: AutoDockCharge 25',
                                'GetConfigSectionValue: AutoDockIdleMins 15',
                                'EndOfGetConfigSectionValues',
                                'GetConfigSectionValue: Map ', 'EndOfGetConfigSectionValues',
                                'CommandError: getConfigSectionValues docking',
                                'CommandErrorDescription: No section of name docking']],
    'getConfigSectionInfo': [['getconfigsectioninfo Files', 'getConfigSectionInfo "Files"'], [
        'GetConfigSectionInfo: "The files the robot uses" ""',
        'GetConfigSectionParamInfo: String Map Intermediate None None '
        '"The map the robot drives on" "" ""', 'EndOfGetConfigSectionInfo',
        'CommandError: getConfigSectionInfo "Files"',
        'CommandErrorDescription: No section of name "Files"']],
    'configStart': [['configStart'], ['New config starting']],
    'configAdd': [['configAdd Section Files', 'configStart', 'configAdd Section Files'],
                  ['SetUpError: You need to start a config before you can add to it.',
                   'New config starting', "Added 'Section Files' to the config"]],
    'configParse': [['configStart', 'configAdd Section Docking', 'configAdd AutoDockCharge 30',
                     'configParse', 'configParse'],
                    ['New config starting', "Added 'Section Docking' to the config",
                     "Added 'AutoDockCharge 30' to the config", 'Will parse config',
                     'Configuration changed', 'Config parsed fine',
                     'SetUpError: You need to start a config before you can parse it.']],
    'newConfigParam': [
        ['newconfigparam Log newparam "this is a test param" Basic string "a test" none none '
         '"a hint"', 'newConfigParam Log depth "how deep" Expert Integer 3 0 None None',
         'getconfigsectioninfo Log', 'getConfigSectionValues Log'],
        ["Will add new param 'newparam' to section 'Log'",
         "Will add new param 'depth' to section 'Log'",
         'GetConfigSectionInfo: "" "CENTRAL_SECTION"',
         'GetConfigSectionParamInfo: String newparam Basic None None "this is a test param" '
         '"a hint" ""',
         'GetConfigSectionParamInfo: Int depth Expert 0 2147483647 "how deep" "" ""',
         'EndOfGetConfigSectionInfo', 'GetConfigSectionValue: newparam a test',
         'GetConfigSectionValue: depth 3', 'EndOfGetConfigSectionValues']],
    'newConfigSectionComment': [
        ['newConfigSectionComment Log "my comments"', 'getconfigsectioninfo Log'],
        ["Will add config comment 'my comments' to section 'Log'",
         'GetConfigSectionInfo: "my comments" "CENTRAL_SECTION"', 'EndOfGetConfigSectionInfo']],
}
