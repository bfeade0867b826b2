"""Transcripts: reading and changing the configuration (form as in `transcripts_state`)."""
from __future__ import annotations

SECTIONS = [  # the maps of both real robots have these sections, in this order
    'Log Config', 'ARCL server setup', 'A/V Config', 'Connection timeouts', 'Destination Drawing',
    'Feedback', 'Outgoing ARCL commands', 'Outgoing ARCL connection setup',
    'Payload Present Messages and Behavior', 'Robot joystick goal button', 'Language/Location',
    'Local EtherNet/IP Device Setup', 'Docking', 'Driving problem response', 'Map Features',
    'Files', 'Localization Modules', 'Localization settings', 'Path Planning Settings', 'Patrol',
    'Periodic Macros', 'Queuing Manager', 'Robot config', 'Standby', 'Teleop Settings',
    'Task Features', 'Triangle Drive To', 'Robot Type', 'Absolute Movement Maximums', 'Payload',
    'MARC Configuration', 'Custom Enterprise Queuing Tasks', 'Enterprise Manager Connection',
]

IMMEDIATE = {
    'getConfigSectionList': [['getConfigSectionList'], [
        *(f'GetConfigSectionList: {section}' for section in SECTIONS),
        'EndOfGetConfigSectionList']],
    'getConfigSectionValues': [['getConfigSectionValues Docking', 'getConfigSectionValues Files',
                                'getConfigSectionValues Path Planning Settings',
                                'getConfigSectionValues Patrol', 'getConfigSectionValues docking'],
                               ['GetConfigSectionValue: AutoDock false',
                                'GetConfigSectionValue: AutoDockStateOfCharge 25',
                                'GetConfigSectionValue: AutoDockIdleTime 15',
                                'EndOfGetConfigSectionValues',
                                'GetConfigSectionValue: Map ', 'EndOfGetConfigSectionValues',
                                'GetConfigSectionValue: MaxSpeed 1350',
                                'GetConfigSectionValue: MaxRotSpeed 100',
                                'GetConfigSectionValue: PlanRes 60',
                                'EndOfGetConfigSectionValues', 'EndOfGetConfigSectionValues',
                                'CommandError: getConfigSectionValues docking',
                                'CommandErrorDescription: No section of name docking']],
    'getConfigSectionInfo': [['getconfigsectioninfo Files', 'getConfigSectionInfo "Files"'], [
        'GetConfigSectionInfo: "The files the robot uses" ""',
        'GetConfigSectionParamInfo: String Map Normal None None '
        '"The map the robot drives on" "" ""', 'EndOfGetConfigSectionInfo',
        'CommandError: getConfigSectionInfo "Files"',
        'CommandErrorDescription: No section of name "Files"']],
    'configStart': [['configStart'], ['New config starting']],
    'configAdd': [['configAdd Section Files', 'configStart', 'configAdd Section Files'],
                  ['SetUpError: You need to start a config before you can add to it.',
                   'New config starting', "Added 'Section Files' to the config"]],
    'configParse': [['configStart', 'configAdd Section Docking',
                     'configAdd AutoDockStateOfCharge 30', 'configParse', 'configParse'],
                    ['New config starting', "Added 'Section Docking' to the config",
                     "Added 'AutoDockStateOfCharge 30' to the config", 'Will parse config',
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
